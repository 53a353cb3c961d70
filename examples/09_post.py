"""The post: a cable winds a strip round a post, and friction holds it there when its base is drawn away.

python examples/09_post.py

A motor draws the base away from the post. What it needs for that is what friction holds.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from tauten.model import Robot, Simulator, load_robot

FILE = Path(__file__).with_name("tentacle.toml")
TENSION, TRAVEL = 1.5, 0.010  # N, of the cable; m, of the base
WOUND, REST, END = (
    0.8,
    1.0,
    1.6,
)  # s: the end of the winding, of the rest after it, and of the drawing


def wind(robot: Robot) -> Iterator[Simulator]:
    """The simulator after each step."""
    simulator, h = Simulator(robot), robot.integration.h
    yield simulator
    winch, motor = (robot.actuators.names.index(name) for name in ("wind", "draw"))
    for step in range(1, round(END / h) + 1):
        position, effort = np.full((2, robot.n_a), np.nan)
        effort[winch] = TENSION * min(step * h / WOUND, 1.0)
        position[motor] = TRAVEL * max(step * h - REST, 0.0) / (END - REST)
        assert simulator.move(position, effort).converged
        yield simulator


def drawn(simulator: Simulator) -> float:
    """The force of the motor [N]."""
    return float(simulator.effort[simulator.robot.actuators.names.index("draw")])


def main() -> None:
    """Wind and draw; the post must push back as much as the motor draws."""
    largest = 0.0
    for simulator in wind(load_robot(FILE)):
        largest = max(largest, drawn(simulator))
    held = simulator.contacts.force.sum(axis=0)[0]
    print(f"the motor draws with up to {largest:.2f} N, at the end {drawn(simulator):.2f} N")
    np.testing.assert_allclose(held, drawn(simulator), rtol=0.01)
    assert largest > 0.7


if __name__ == "__main__":
    main()
