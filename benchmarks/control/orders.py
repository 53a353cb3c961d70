"""Random orders of `python -m benchmarks still`: whether robots get stuck, and what leaves beyond limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.controller import Controller
from tauten.model import Robot
from tauten.model.numerics import Array
from tauten.service.process import StopFlag
from tauten.service.setup import Setup

AFTER = 1.0  # s, from the last unlock and the time that slack takes until decisions go on


@dataclass(frozen=True, slots=True)
class OrderRun:
    """Random orders.

    Attributes:
        robot: name.
        orders: how many.
        unusable: decisions among them that could not be used.
        stuck: unusable decisions after the last unlock and the time to wind in what is slack.
        beyond: largest share by which what left exceeded a limit.
        needed: largest share by which the model's efforts exceed a limit at the end.
    """

    robot: str
    orders: int
    unusable: int
    stuck: int
    beyond: float
    needed: float


def order_run(setup: Setup, orders: int, seed: int, stop: StopFlag) -> OrderRun:
    """Random orders, then targets at the start until decisions go on.

    Args:
        setup: of the robot.
        orders: how many.
        seed: of them.
        stop: ends the run.

    Raises:
        Interrupted: it did.
    """
    rng, robot = np.random.default_rng(seed), setup.robot
    controller = Controller(robot, setup.contact, settings=setup.controller)
    controller.settle_start()
    start, layout, limits = controller.effector_values, robot.effector_layout, robot.limits
    unusable, stuck, beyond = 0, 0, 0.0
    names, goal = robot.actuators.names, start
    for _ in range(orders):
        stop.heed()
        i, choice = int(rng.integers(len(names))), int(rng.integers(5))
        if choice == 0:
            controller.lock(
                names[i], position=_within(rng, limits.position_min, limits.position_max, i)
            )
        elif choice == 1:
            controller.lock(names[i], force=_within(rng, limits.effort_min, limits.effort_max, i))
        elif choice == 2:
            _unlock(controller, i)
        elif choice == 3:
            change = rng.normal(size=layout.n_rows) * 0.1 * robot.size / layout.units
            goal = layout.moved(start, change)
        for _ in range(int(rng.integers(1, 5))):
            actuation = controller.hold() if choice == 4 else controller.decide(goal)
            controller.advance()
            unusable += choice != 4 and not actuation.status.usable
            beyond = max(beyond, _excess(robot, actuation.effort, actuation.position))
    for i in range(len(names)):
        _unlock(controller, i)
    slack = (limits.position_max - limits.position_min) / limits.rate  # (n_a,) s, at most
    wait = round((float(slack.max()) + AFTER) / robot.h)
    for tick in range(wait + round(AFTER / robot.h)):
        actuation = controller.step(start)
        stuck += tick >= wait and not actuation.status.usable
        beyond = max(beyond, _excess(robot, actuation.effort, actuation.position))
    needed = _excess(robot, actuation.needed, actuation.position)
    return OrderRun(robot.name, orders, unusable, stuck, beyond, needed)


def _within(rng: np.random.Generator, least: Array, most: Array, i: int) -> float:
    """A random value between limits (n_a,) of actuator i."""
    return float(rng.uniform(least[i], most[i]))


def _unlock(controller: Controller, i: int) -> None:
    """Decide actuator i again, where it is locked."""
    locks = controller.locks
    if locks.by_position[i] or locks.by_force[i]:
        controller.unlock(controller.robot.actuators.names[i])


def _excess(robot: Robot, effort: Array, position: Array) -> float:
    """Largest share by which efforts and positions (n_a,) are beyond their limits."""
    limits = robot.limits
    above = np.maximum(effort - limits.effort_max, limits.effort_min - effort)
    outside = np.maximum(position - limits.position_max, limits.position_min - position)
    share = np.maximum(
        above / limits.largest_effort, outside / (limits.position_max - limits.position_min)
    )
    return max(float(share.max()), 0.0)
