"""The crawler: two cables pull and let go in turn, and friction moves the strip forward.

python examples/07_crawler.py

The rear cable pulls while the front foot holds, then the front cable pulls while the rear one lets go, which
lifts the middle foot over, then the front foot is let go. What holds carries more weight than what slides.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from tauten.model import Robot, Simulator, load_robot
from tauten.model.numerics import Array

FILE = Path(__file__).with_name("crawler.toml")
STROKE, PERIOD = 0.006, 1.0  # m, pulled length of a cable; s, of a cycle
SETTLING = 0.1  # s, before the first cycle
# Pulled lengths of the cables (rear, front) at the thirds of a cycle.
GAIT = STROKE * np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, 0.0]])


def pulled(time: float) -> Array:
    """Pulled lengths of the cables at a time since the first cycle began: (2,) [m]."""
    share = 3.0 * (max(time, 0.0) / PERIOD % 1.0)
    third = int(share)
    way = 0.5 - 0.5 * np.cos(np.pi * (share - third))  # starts and ends at rest
    lengths: Array = (1.0 - way) * GAIT[third] + way * GAIT[third + 1]
    return lengths


def crawl(robot: Robot, cycles: float) -> Iterator[Simulator]:
    """The simulator after each step of some cycles."""
    simulator = Simulator(robot)
    yield simulator
    h = robot.integration.h
    for step in range(1, round((SETTLING + cycles * PERIOD) / h) + 1):
        assert simulator.move(position=pulled(step * h - SETTLING)).converged
        yield simulator


def main() -> None:
    """Crawl for three cycles; a cycle takes the strip forward by what a cable is shortened."""
    robot = load_robot(FILE)
    cycles = 3
    places = [simulator.tip[0] for simulator in crawl(robot, cycles)]
    travel = (places[-1] - places[0]) / cycles
    print(f"{1e3 * travel:.2f} mm a cycle, stroke {1e3 * STROKE:.1f} mm")
    assert abs(travel - STROKE) < 0.03 * STROKE


if __name__ == "__main__":
    main()
