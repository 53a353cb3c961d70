"""The ring: cables across it make it oval, and the oval goes round in it, so that it rolls over the floor.

python examples/13_ring.py

Two cables at right angles are pulled and paid out by as much. The direction of the shortest diameter turns
against the ring, which tips over its longest one, again and again. It is the robot of Sugiyama and Hirai,
"Crawling and jumping by a deformable robot" (2006). Nothing but friction pushes it.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from tauten.model import Robot, Simulator, load_robot
from tauten.model.numerics import Array

FILE = Path(__file__).with_name("ring.toml")
RADIUS = 0.024  # m, outside
STROKE, LONGER = 0.006, 1.3  # m, of a cable; how much more it is paid out than pulled
TURN, SETTLING = 2.0, 0.3  # s: in which the oval turns by half, and in which it is made


def pulled(robot: Robot, time: float) -> Array:
    """Pulled lengths of the cables at a time: (4,) [m]."""
    share = min(time / SETTLING, 1.0)
    # the angle of the shortest diameter in the ring
    short = np.pi * (0.5 + max(time - SETTLING, 0.0) / TURN)
    across = 0.25 * np.pi * np.arange(robot.n_a)
    oval = np.cos(2.0 * (across - short))
    lengths: Array = share * STROKE * np.where(oval < 0.0, LONGER, 1.0) * oval
    return lengths


def roll(robot: Robot, turns: float) -> Iterator[Simulator]:
    """The simulator after each step.

    Args:
        robot: of the file.
        turns: half turns of the oval in the ring.
    """
    simulator, h = Simulator(robot), robot.integration.h
    yield simulator
    for step in range(1, round((SETTLING + turns * TURN) / h) + 1):
        # where the ring tips, one step a period errs by 5 mm, two by 0.1 mm
        assert simulator.move(position=pulled(robot, step * h), steps=2).converged
        yield simulator


def turned(simulator: Simulator) -> float:
    """The angle about the axis of the ring by which it has rolled, from -π to π [rad]."""
    robot = simulator.robot
    start, now = (robot.points(state) for state in (robot.rest(), simulator.state))
    (x, z), (u, w) = ((p - p.mean(axis=0)).T[[0, 2]] for p in (start, now))
    return float(np.arctan2((z * u - x * w).sum(), (x * u + z * w).sum()))


def main() -> None:
    """Roll for two half turns."""
    robot = load_robot(FILE)
    states = [(simulator.tip[0], turned(simulator)) for simulator in roll(robot, 2)]
    places, angles = np.array(states).T
    angle = float(np.unwrap(angles)[-1])
    travel = places[-1] - places[0]
    print(f"{1e3 * travel:.1f} mm, turned by {np.degrees(angle):.0f} degrees")
    assert angle > 0.8 * 2.0 * np.pi
    np.testing.assert_allclose(travel, RADIUS * angle, rtol=0.1)


if __name__ == "__main__":
    main()
