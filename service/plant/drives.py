"""A simulated robot between commands: its drives move within their rates, in steps of its own.

How many steps a period needs is measured on a trial motion: so many that twice as many move the effectors by
less than `ALLOWED` of their way.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from time import perf_counter
from typing import Literal

import numpy as np

from tauten.model import Command, Report, Robot, Simulator
from tauten.model.numerics import Array, Bools, FactorisationError

Drive = Literal["pull", "tension"]

ALLOWED = 0.005  # of the way of an effector
MOST = 16  # steps in a period
_TRIAL = 0.6  # s, of the trial motion
_SHARE = 0.5  # of an actuator's range, in the trial
_LEAST_SHARE = 0.03


@dataclass(frozen=True, slots=True)
class OwnSteps:
    """Steps of a simulated robot.

    Attributes:
        count: in a period of control.
        error: how far twice as many move an effector in the trial motion, relative to its way.
        speed: simulated time over real time in the trial.
    """

    count: int
    error: float
    speed: float


class DrivenRobot:
    """A simulated robot whose drives move evenly, and within their rates, from one command to the next.

    Attributes:
        simulator: of the robot.
        steps: in a period.
    """

    def __init__(self, simulator: Simulator, steps: int) -> None:
        self.simulator, self.steps = simulator, steps
        self._position: Array | None = None

    def reset(self) -> None:
        """Return to the simulator's start."""
        self.simulator.reset()
        self._position = None

    def move(self, position: Array, effort: Array) -> Report:
        """One period to positions (n_a,) [m, m³] or efforts (n_a,) [N, Pa]; NaN in one of them.

        Positions are reached as far as the rates permit.

        Raises:
            FactorisationError: the state has diverged.
        """
        robot = self.simulator.robot
        before = self.simulator.position if self._position is None else self._position
        before = np.where(np.isnan(before), self.simulator.position, before)
        reach = robot.h * robot.limits.rate  # (n_a,)
        self._position = np.clip(position, before - reach, before + reach)
        return self.simulator.move(self._position, effort, self.steps)

    def follow(self, position: Array, effort: Array, drive: Drive = "pull") -> bool:
        """One period under what a node sends; False where the motion diverges: it starts again then.

        Args:
            position: (n_a,) positions.
            effort: (n_a,) efforts.
            drive: which it obeys: "tension", efforts; "pull", positions, and efforts of actuators that a hold
                keeps by these, as of pressure.
        """
        by_force = self.simulator.robot.actuators.laws.held_by_force | (drive == "tension")
        given = Command.either(by_force, position, effort)
        try:
            self.move(given.position, given.effort)
        except FactorisationError:
            self.reset()
            return False
        return True


def own_steps(simulator: Simulator) -> OwnSteps:
    """How many steps a simulated robot needs in a period; the simulator returns to its start.

    A trial motion on which steps find no state, at an effort beyond the limits, is no motion of the robot:
    one of half the way replaces it.

    Raises:
        FactorisationError: the trial motion diverges.
    """
    share = _SHARE
    while share > _LEAST_SHARE:
        with suppress(FactorisationError):
            return _steps_on(simulator, share, within_limits=True)
        share *= 0.5
    return _steps_on(simulator, _SHARE, within_limits=False)


def _steps_on(simulator: Simulator, share: float, *, within_limits: bool) -> OwnSteps:
    coarse, _ = _trial(simulator, 1, share, within_limits)
    count = 1
    while True:
        fine, seconds = _trial(simulator, 2 * count, share, within_limits)
        way = np.linalg.norm(fine - fine[:1], axis=2).max()  # m
        apart = np.linalg.norm(fine - coarse, axis=2).max()
        error = float(apart / max(way, 1e-6 * simulator.robot.size))
        if error < ALLOWED or 2 * count >= MOST:
            speed = _TRIAL / (0.5 * seconds)
            simulator.reset()
            return OwnSteps(count, error, speed)
        coarse, count = fine, 2 * count


def _trial(
    simulator: Simulator, steps: int, most: float, within_limits: bool
) -> tuple[Array, float]:
    """Effectors (ticks, p, 3) [m] while the first actuator moves there and back; real time of it [s].

    Raises:
        FactorisationError: the motion diverges, or `within_limits` and a period finds no state, at an effort
            beyond the limits.
    """
    simulator.reset()
    robot, found = simulator.robot, []
    by_force, ticks = yielding(robot), max(round(_TRIAL / robot.h), 2)
    by_force[0] = robot.actuators.laws.held_by_force[0]
    way = 0.25 * _TRIAL * float(robot.limits.rate[0]) / _SHARE
    far = float(np.clip(robot.limits.farthest_position[0], -way, way))
    start_position, start_effort = simulator.position, simulator.effort
    begin = perf_counter()
    for share in 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(1, ticks + 1) / ticks):
        given = Command.either(by_force, start_position, start_effort)
        if by_force[0]:
            given.effort[0] += share * most * (robot.limits.effort_max[0] - start_effort[0])
        else:
            given.position[0] += share * most * far
        report = simulator.move(given.position, given.effort, steps)
        if within_limits and not report.converged and _beyond_limits(simulator):
            raise FactorisationError("no state within the limits of efforts")
        found.append(simulator.effector)
    return np.array(found), perf_counter() - begin


def yielding(robot: Robot) -> Bools:
    """Which actuators keep their efforts while others move, so that they yield to them: (n_a,)."""
    laws = robot.actuators.laws
    chosen: Bools = laws.held_by_force | ~laws.bilateral
    return chosen


def _beyond_limits(simulator: Simulator) -> bool:
    limits, effort = simulator.robot.limits, simulator.effort
    return bool(np.any((effort < limits.effort_min) | (effort > limits.effort_max)))
