"""The roll: a soft pad brings a ball to a target on the floor, through contact alone.

python examples/14_roll.py

The effector is the centre of the ball, which nothing holds. A controller with exact friction presses a soft
pad on it and pulls the pad to the sides, so that the ball rolls between pad and floor, half as far as the
pad. The controller moves a simulated robot of the same file.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from tauten.controller import Controller
from tauten.model import Robot, Simulator, load_robot
from tauten.model.numerics import Array

FILE = Path(__file__).with_name("roll.toml")
RADIUS = 0.010  # m, of the ball
WAY = (0.003, 0.001)  # m, of the target along x and y
TIME, REST = 1.0, 0.8  # s, of the target's way and of its rest


def roll(
    robot: Robot, way: tuple[float, float] = WAY, time: float = TIME, rest: float = REST
) -> Iterator[Simulator]:
    """The simulated robot after each step; the target starts and stops smoothly.

    Args:
        robot: of the file, or with other contacts, which its controller knows.
        way: of the target along x and y [m].
        time: that it takes [s].
        rest: of the target at its end [s].
    """
    controller, simulator = Controller(robot), Simulator(robot)
    start, h = controller.effector, robot.integration.h
    yield simulator
    for step in range(1, round((time + rest) / h) + 1):
        share = min(step * h / time, 1.0)
        goal = start + share * share * (3.0 - 2.0 * share) * np.array([*way, 0.0])
        actuation = controller.step(goal)
        assert actuation.status.usable
        simulator.move(position=actuation.position)
        yield simulator


def moved(simulator: Simulator) -> Array:
    """How far the ball has moved along x and y: (2,) [m]."""
    robot = simulator.robot
    found: Array = (simulator.tip - robot.points(robot.rest())[-1])[:2]
    return found


def turned(simulator: Simulator) -> Array:
    """By how much the ball has turned about the axes x and y: (2,) [rad]."""
    robot = simulator.robot
    ball = robot.body.part_robots[1].n_nodes
    start, now = (robot.points(state)[-ball:] for state in (robot.rest(), simulator.state))
    turn, _ = Rotation.align_vectors(now - now[-1], start - start[-1])
    found: Array = turn.as_rotvec()[:2]
    return found


def pressed(simulator: Simulator) -> float:
    """The force of the pad on the ball, downwards [N]."""
    found = simulator.contacts
    return float(-found.force[found.contacts.pair == 0].sum(axis=0)[2])


def main() -> None:
    """Roll the ball by three millimetres to the right and one to the back."""
    *_, simulator = roll(load_robot(FILE))
    missed = np.linalg.norm(moved(simulator) - WAY)
    x, y = turned(simulator)
    print(
        f"the ball has rolled {1e3 * moved(simulator).round(5)} mm, {1e3 * missed:.2f} mm from its target"
    )
    assert missed < 2e-4
    np.testing.assert_allclose(RADIUS * np.array([y, -x]), moved(simulator), atol=3e-4)


if __name__ == "__main__":
    main()
