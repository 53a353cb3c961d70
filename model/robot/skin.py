"""What of a robot is drawn: the skin of its deformed body, its actuators, the contacts that push."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from tauten.model.numerics import Array, Ints
from tauten.model.robot.robot import Robot
from tauten.model.state import State

Floats: TypeAlias = NDArray[np.float32]  # positions for drawing

_PUSHING = 1e-3  # of the largest force; smaller ones are not drawn


@dataclass(frozen=True, slots=True)
class PushingContacts:
    """Contacts that push.

    Attributes:
        points: (c, 3) [m].
        forces: (c, 3) on the body at these points [N].
    """

    points: Floats
    forces: Floats


NO_CONTACTS = PushingContacts(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.float32))


@dataclass(frozen=True, slots=True)
class Geometry:
    """Where a robot is.

    Attributes:
        vertices: (P, 3) of its skin [m].
        segments: (s, 2, 3) segments of the actuators [m], see `Robot.actuator_segments`.
        contacts: that push.
    """

    vertices: Floats
    segments: Floats
    contacts: PushingContacts


@dataclass(frozen=True, slots=True)
class SkinMesh:
    """The vertices of a robot's surface among its points.

    Attributes:
        used: (P,) which of the robot's points they are.
        triangles: (t, 3) of the vertices.
    """

    used: Ints
    triangles: Ints

    def geometry(self, robot: Robot, state: State, forces: Array | None) -> Geometry:
        """Where a robot is.

        Args:
            robot: whose skin this is.
            state: of the robot.
            forces: (n_c, 3) on the candidates [N]; None: they are left out, which is
                faster.
        """
        return Geometry(
            robot.points(state)[self.used].astype(np.float32),
            robot.actuator_segments(state).astype(np.float32),
            NO_CONTACTS if forces is None else pushing_contacts(robot, state, forces),
        )


def skin_of(robot: Robot) -> SkinMesh:
    """The skin of a robot."""
    used, inverse = np.unique(robot.triangles, return_inverse=True)
    return SkinMesh(used, inverse.reshape(-1, 3))


def pushing_contacts(robot: Robot, state: State, forces: Array) -> PushingContacts:
    """Contacts that push in a state.

    Args:
        robot: the robot.
        state: of the robot.
        forces: (n_c, 3) on the candidates [N].
    """
    lam = np.linalg.norm(forces, axis=1)
    largest = float(lam.max(initial=0.0))
    if not largest > 0.0:
        return NO_CONTACTS
    shown = np.flatnonzero(lam > _PUSHING * largest)
    points = robot.candidates(state)[shown]
    return PushingContacts(points.astype(np.float32), forces[shown].astype(np.float32))
