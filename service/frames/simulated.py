"""Model and plant in one process: the control loop of a node, and the robot that it drives."""

from __future__ import annotations

import time

import numpy as np

from tauten.controller import warm_controller
from tauten.model import skin_of, static_compliance
from tauten.model.numerics import Array
from tauten.service.describing import describe
from tauten.service.frames.frame import RobotLook, ViewFrame
from tauten.service.node import ControlLoop, Signals
from tauten.service.plant import PlantSettings, place_rows, warm_plant
from tauten.service.setup import Setup
from tauten.service.wire import OperatorOrder

_SPRING = 0.5  # longest spring that pulls the robot, as a share of its size
_REMEMBERED = 3.0  # s for which the panel says why an order was refused
_PACE = 0.1  # share of a new duration in the mean


class SimulatedRobot:
    """A robot that is simulated: full-order plant with pointwise contact, driven by a node's control loop.

    Attributes:
        look: what of the robot does not change.
        pausable: always; time is that of the simulation.
        silence: time for which its node has been missing [s]: it has none.
        nodes: of the plant.
        plant: order of the plant, its steps and their error.
    """

    pausable, silence = True, 0.0

    def __init__(self, setup: Setup, simulated: Setup, order: str = "full") -> None:
        """Start where model and plant settle under their loads, with every kernel compiled."""
        plant = simulated.robot
        self._loop = ControlLoop(warm_controller(setup), settings=setup.service)
        warm = warm_plant(plant, PlantSettings(), order)
        self._driven, self._simulator, self.plant = warm.driven, warm.driven.simulator, warm.fields
        self._skin, self._ghost = skin_of(plant), skin_of(setup.robot)
        self._h = plant.h
        self.nodes = plant.n_nodes
        self._steps = 0
        self._seconds = 0.0  # of model and plant together, in the mean
        self._resets = 0
        self._pulled, self._stiff = False, dict[int, float]()
        self._refused = ("", 0)  # why an order was refused, and the step then
        start = self._simulator.state
        self.look = RobotLook(
            describe(simulated, plant.effector_values(start)),
            self._skin.geometry(plant, start, None).vertices,
            self._ghost.triangles,
        )

    @property
    def notes(self) -> tuple[str, ...]:
        """Whether the computer keeps up with time, and whether the simulation had to start again."""
        found = []
        if self._seconds > self._h:
            found.append(f"simulated at {self._h / self._seconds:.2f} times real time")
        if self._resets:
            found.append(f"the simulation has blown up {self._resets} times and started again")
        refused, then = self._refused
        if refused and (self._steps - then) * self._h < _REMEMBERED:
            found.append(refused)
        return tuple(found)

    @property
    def locked(self) -> frozenset[str]:
        """Names of the actuators that are locked."""
        locks = self._loop.controller.locks
        names = np.array(self._loop.controller.robot.actuators.names)
        return frozenset(names[locks.by_position | locks.by_force].tolist())

    def command(self, command: OperatorOrder) -> None:
        """Obey an operator's order where it is possible."""
        refused = self._loop.obey(command)
        self._refused = ("" if refused is None else refused.detail), self._steps

    def pull(self, effector: int, end: Array | None) -> Array | None:
        """Pull the simulated robot at an effector by a spring; what decides does not know of it.

        The spring, as stiff as the robot is there at rest in its softest direction, ends at (3,) [m]; None:
        there is none. Returns the force (3,) on the effector [N]; None without a spring.
        """
        simulator = self._simulator
        forces = np.zeros((len(self.look.robot.effectors), 3))
        if end is not None:
            away = end - simulator.effector[effector]
            longest = _SPRING * self.look.robot.size
            away *= min(1.0, longest / max(float(np.linalg.norm(away)), 1e-12))
            forces[effector] = self._stiffness(effector) * away
        elif not self._pulled:
            return None
        self._pulled = end is not None
        simulator.load(simulator.robot.gravity, forces.ravel())
        return forces[effector] if self._pulled else None

    def _stiffness(self, effector: int) -> float:
        """Of the robot at rest in its softest direction at an effector [N/m]."""
        if effector not in self._stiff:
            robot = self._simulator.robot
            rows = robot.rows(robot.rest(), contacts=False).effectors
            W = static_compliance(robot, rows.dense()[place_rows(robot, effector)])
            self._stiff[effector] = 1.0 / float(np.linalg.eigvalsh(W).max())
        return self._stiff[effector]

    def advance(self, goal: Array | None, drawn: bool) -> ViewFrame | None:
        """One period of model and plant; its frame, None where there is none, or none is wanted.

        Args:
            goal: (n_v,) goal values to follow; None: nothing to follow.
            drawn: whether a frame is wanted.
        """
        begin = time.perf_counter()
        action = self._loop.tick(goal, Signals(target=goal is not None))
        self._loop.prepare()
        step = time.perf_counter() - begin
        simulator = self._simulator
        sent = action.actuation
        self._resets += not self._driven.follow(sent.position, sent.effort)
        self._steps += 1
        self._seconds += _PACE * (time.perf_counter() - begin - self._seconds)
        if not drawn:
            return None
        state, model = simulator.state, self._loop.controller
        values = simulator.robot.effector_values(state)
        return ViewFrame(
            time=self._steps * self._h,
            mode=action.mode,
            cause=action.cause,
            status="" if action.status is None else action.status.name,
            geometry=self._skin.geometry(simulator.robot, state, simulator.contacts),
            position=simulator.position,
            effort=simulator.effort,
            goal=np.full_like(values, np.nan) if goal is None else goal,
            values=values,
            step=step,
            ghost=self._ghost.geometry(model.robot, model.state, None).vertices,
            modelled=model.robot.effector_values(model.state),
            obstacles=simulator.obstacles.by_name,
            decided=sent.effort,
        )
