"""What a simulator and a controller have in common: a robot in a state, with its obstacles around it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from tauten.model.arguments import of_kind
from tauten.model.contact import ObstaclePose, ObstaclePoses, pose_at
from tauten.model.contacts import ContactForces
from tauten.model.friction import FrictionCertificate
from tauten.model.numerics import Array
from tauten.model.robot import Robot
from tauten.model.simulation.commands import (
    Numbers,
    checked_command,
    checked_forces,
    checked_state,
)
from tauten.model.state import State
from tauten.model.step import ContactSpace, Forces, PredictedStep, step_certificate


class RobotModel:
    """A robot in a state, with its obstacles around it. Arrays that it returns are copies.

    Attributes:
        space: basis of its contact forces.
    """

    space: ContactSpace
    _robot: Robot
    _state: State
    _forces: Forces
    # a state, and the step that led there or starts there
    _stepped: tuple[State, PredictedStep] | None

    @classmethod
    def _forked(cls, robot: object) -> Robot:
        """A robot with a workspace of its own; a TypeError says what to call where it is none."""
        if isinstance(robot, Robot):
            return robot.fork()
        if isinstance(robot, str | Path):
            given = repr(str(robot))
            advice = f"{cls.__name__}.of({given}) starts from a name or a file"
        else:
            given, advice = type(robot).__name__, "load_robot loads one"
        raise TypeError(f"{cls.__name__} takes a Robot, found {given}: {advice}")

    def _checked_start(
        self, state: State, forces: Forces, k: int, position: Numbers
    ) -> tuple[State, Forces, Array]:
        """Copies of a state, forces with k columns of a basis, and positions (n_a,) of the actuators.

        Raises:
            TypeError, ValueError: these are none, or of another robot or basis, by their size.
        """
        given = checked_command(self._robot, position, None).position
        return checked_state(self._robot, state), checked_forces(self._robot, k, forces), given

    @property
    def robot(self) -> Robot:
        """The robot, with a factorisation of its own and its obstacles where they are now."""
        return self._robot

    @property
    def period(self) -> float:
        """Time between two steps [s]."""
        return self.robot.h

    @property
    def state(self) -> State:
        """Configuration and velocity."""
        return self._state.copy()

    @property
    def forces(self) -> Forces:
        """Constraint forces of the last step."""
        return self._forces.copy()

    @property
    def lam_c(self) -> Array:
        """Normal force of every candidate in the last step: (n_c,) [N]."""
        return self._forces.at_candidates(self.space, self._robot.contacts.without_friction)

    @property
    def contacts(self) -> ContactForces:
        """The contacts in range in the last step: their forces, and which slide."""
        if self._stepped is not None and self._stepped[0] is self._state:
            return self._forces.on(self._stepped[1].step.rows.contacts.found, self.space)
        return self._forces.on(self._robot.rows(self._state).contacts.found, self.space)

    @property
    def contact_forces(self) -> Array:
        """Forces on every candidate in that step, with friction: (n_c, 3) [N]."""
        return self.contacts.at_candidates()

    @property
    def certificate(self) -> FrictionCertificate | None:
        """Of the contacts with friction in the last step; None where none pushed, and without a step yet."""
        return self.certified()

    def certified(self, quickly: bool = False) -> FrictionCertificate | None:
        """The certificate; quickly, as between two ticks, a jam that is hard to tell is not found."""
        if self._stepped is None or self._stepped[0] is not self._state:
            return None
        return step_certificate(self._stepped[1], quickly)

    @property
    def effector(self) -> Array:
        """Positions of the effectors: (p, 3) [m]."""
        return self._robot.effector(self._state).copy()

    @property
    def effector_values(self) -> Array:
        """Goal values of the effectors: (n_v,), see `EffectorLayout`."""
        return self._robot.effector_values(self._state).copy()

    @property
    def tip(self) -> Array:
        """Position of the first effector: (3,) [m]."""
        return np.array(self.effector[0])

    @property
    def obstacles(self) -> ObstaclePoses:
        """Where the obstacles are now."""
        return self._robot.obstacles

    def set_obstacles(self, poses: ObstaclePoses) -> None:
        """Have the obstacles in other poses from the next step on.

        Raises:
            TypeError, ValueError: these are no poses, or those of other obstacles, by their names.
        """
        found, own = of_kind("poses", poses, ObstaclePoses).names, self.obstacles.names
        if found != own:
            of_those, of_these = (", ".join(names) or "none" for names in (found, own))
            raise ValueError(f"poses: found those of {of_those}, expected those of {of_these}")
        self._robot = self._robot.with_obstacles(poses)

    def depth_of(self, obstacle: str, pose: ObstaclePose) -> float:
        """How deep candidates of the robot would be in an obstacle at a pose [m]; 0 where they are not.

        Raises:
            ValueError: no such obstacle.
        """
        robot = self._robot.with_obstacles(self.obstacles.with_pose(obstacle, pose))
        found = robot.rows(self._state).contacts.found
        own = [
            number
            for number, pair in enumerate(robot.contacts.pairs)
            if pair.obstacle is not None and pair.obstacle.name == obstacle
        ]
        return max(0.0, -float(found.gap[np.isin(found.pair, own)].min(initial=0.0)))

    def place(
        self,
        obstacle: str,
        position: Sequence[float] | Array,
        quaternion: Sequence[float] | Array | None = None,
        velocity: Sequence[float] | Array | None = None,
        spin: Sequence[float] | Array | None = None,
    ) -> None:
        """Put an obstacle elsewhere; from then on it moves at this velocity, and along no path.

        Args:
            obstacle: name.
            position: (3,) of the origin of its frame [m].
            quaternion: (4,) of its rotation, w, x, y, z; None: none.
            velocity: (3,) [m/s]; None: it stands still.
            spin: (3,) angular velocity about the axes of the robot's frame [rad/s]; None: zero.

        Raises:
            ValueError: no such obstacle, or numbers that are no pose.
        """
        pose = pose_at(position, quaternion, velocity, spin)
        self.set_obstacles(self.obstacles.with_pose(obstacle, pose))
