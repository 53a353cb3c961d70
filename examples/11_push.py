"""The push: a controller moves a block over the floor to a target, through contact alone.

python examples/11_push.py

The effector is the centre of the block, which no cable holds: what moves it is a soft finger beside it. The
controller decides with exact friction; it moves a simulated robot of the same file.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from tauten.controller import Controller
from tauten.model import Robot, Simulator, load_robot
from tauten.model.numerics import Array

FILE = Path(__file__).with_name("push.toml")
START, WAY = 0.0145, 0.010  # m, of the block's centre along x
TIME, REST = 1.0, 0.3  # s, of the target's way and of its rest


def push(robot: Robot, way: float = WAY, time: float = TIME) -> Iterator[Simulator]:
    """The simulated robot after each step: the target moves evenly and stops.

    Args:
        robot: of the file.
        way: of the target along x [m].
        time: that it takes [s].
    """
    controller, simulator = Controller.of(FILE), Simulator(robot)
    start, h = controller.effector, robot.integration.h
    yield simulator
    for step in range(1, round((time + REST) / h) + 1):
        share = min(step * h / time, 1.0)
        goal = start + np.array([share * share * (3.0 - 2.0 * share) * way, 0.0, 0.0])
        actuation = controller.step(goal)
        assert actuation.status.usable
        assert simulator.move(position=actuation.position).converged
        yield simulator


def pushed(simulator: Simulator) -> float:
    """The force of the finger on the block along x [N]."""
    found = simulator.contacts
    return float(-found.force[found.contacts.pair == 0].sum(axis=0)[0])


def floor_force(simulator: Simulator) -> Array:
    """The force of the floor on the block: (3,) [N]."""
    found = simulator.contacts
    force: Array = found.force[found.contacts.pair == 1].sum(axis=0)
    return force


def main() -> None:
    """Push the block by a centimetre."""
    *_, simulator = push(load_robot(FILE))
    missed = simulator.tip[0] - START - WAY
    print(f"the block has moved {1e3 * (simulator.tip[0] - START):.2f} mm of {1e3 * WAY:.0f} mm")
    assert abs(missed) < 2e-4
    np.testing.assert_allclose(floor_force(simulator)[0], -pushed(simulator), atol=1e-3)


if __name__ == "__main__":
    main()
