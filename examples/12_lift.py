"""The lift: a gripper is told only where a cube is to go, and closes, squeezes and lifts it.

python examples/12_lift.py

The effector is the cube, which nothing but friction holds. Decisions count on 0.66 of its friction
(`friction_share`, by default), so that a cube that is 20 % heavier and has 20 % less friction is held too.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from tauten.controller import Controller
from tauten.model import Robot, Simulator, load_robot
from tauten.model.numerics import Array

FILE = Path(__file__).with_name("lift.toml")
AXIS = np.array([0.0, 0.0, 0.012])  # m, a point of the axis that the palm turns about
ANGLE = 0.2  # rad, of the way of the target
BEGIN, TIME, END = 0.04, 0.7, 1.1  # s: when the target begins to move, for how long, and the end


def goal(time: float, place: Array) -> Array:
    """Where the cube is to be (3,) at a time [s], from its place at the start [m]."""
    angle = ANGLE * min(max((time - BEGIN) / TIME, 0.0), 1.0)
    cos, sin = np.cos(angle), np.sin(angle)
    turn = np.array([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]])
    found: Array = AXIS + turn @ (place - AXIS)
    return found


def lift(robot: Robot, until: float = END) -> Iterator[Simulator]:
    """The simulated robot after each step.

    Args:
        robot: of the file, or with another cube.
        until: time at the end [s].
    """
    controller, simulator = Controller.of(FILE), Simulator(robot)
    place, h = controller.effector_values, controller.period
    yield simulator
    for step in range(1, round(until / h) + 1):
        actuation = controller.step(goal(step * h, place))
        assert actuation.status.usable
        assert simulator.move(position=actuation.position).converged
        yield simulator


def grip(simulator: Simulator) -> float:
    """The force of the fingers on the cube, upwards [N]."""
    found = simulator.contacts
    return float(-found.force[found.contacts.pair == 0].sum(axis=0)[2])


def main() -> None:
    """Lift the cube."""
    robot = load_robot(FILE)
    *_, simulator = lift(robot)
    start = Simulator(robot).effector_values
    weight = 9.81 * robot.body.part_robots[1].body.moving_mass
    missed = np.linalg.norm(simulator.effector_values - goal(END, start))
    print(
        f"lifted {1e3 * (simulator.effector_values - start)[2]:.1f} mm, {1e3 * missed:.2f} mm from its target"
    )
    assert missed < 1e-3
    np.testing.assert_allclose(grip(simulator), weight, rtol=0.02)


if __name__ == "__main__":
    main()
