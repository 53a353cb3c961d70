"""The grasp: two soft fingers lift a cube, turn it upside down and put it down on the other side.

python examples/08_grasp.py

Only friction holds the cube. The tension of the cable squeezes more than its weight needs, so that it is held
with 20 % more mass and 20 % less friction too.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from tauten.model import Robot, Simulator, load_robot
from tauten.model.numerics import Array

FILE = Path(__file__).with_name("grasp.toml")
TENSION = 1.5  # N, of the cable that closes the fingers
# Times [s] with the angle of the palm [rad] and the share of the tension; between them both change smoothly.
COURSE = np.array(
    [
        [0.00, 0.0, 0.0],
        [0.20, 0.0, 1.0],
        [0.70, 0.5 * np.pi, 1.0],
        [0.90, 0.5 * np.pi, 1.0],  # at the top
        [1.40, np.pi, 1.0],
        [1.50, np.pi, 1.0],
        [1.60, np.pi, 0.0],
        [1.80, np.pi, 0.0],
    ]
)
TOP, END = 0.9, 1.8  # s


def commanded(time: float, tension: float) -> tuple[float, float]:
    """Angle of the palm [rad] and tension of the cable [N] at a time [s]."""
    last = min(int(np.searchsorted(COURSE[:, 0], time, side="right")), len(COURSE) - 1)
    (t0, *before), (t1, *after) = COURSE[last - 1], COURSE[last]
    share = min((time - t0) / (t1 - t0), 1.0)
    way = share * share * (3.0 - 2.0 * share)
    angle, closed = (1.0 - way) * np.array(before) + way * np.array(after)
    return float(angle), float(closed) * tension


def carry(robot: Robot, tension: float = TENSION, until: float = END) -> Iterator[Simulator]:
    """The simulator after each step up to a time [s]."""
    simulator, h = Simulator(robot), robot.integration.h
    yield simulator
    turn, close = (robot.actuators.names.index(f"fork_{name}") for name in ("turn", "close"))
    for step in range(1, round(until / h) + 1):
        position, effort = np.full((2, robot.n_a), np.nan)
        position[turn], effort[close] = commanded(step * h, tension)
        assert simulator.move(position, effort).converged
        yield simulator


def cube(simulator: Simulator) -> Array:
    """The nodes of the cube: (27, 3) [m]."""
    robot = simulator.robot
    return robot.points(simulator.state)[-robot.body.part_robots[1].n_nodes :]


def grip(simulator: Simulator) -> Array:
    """The force of the fingers on the cube: (3,) [N]."""
    found = simulator.contacts
    force: Array = -found.force[found.contacts.pair == 0].sum(axis=0)
    return force


def main() -> None:
    """Carry the cube to the other side."""
    robot = load_robot(FILE)
    weight = 9.81 * robot.body.part_robots[1].body.moving_mass
    now, h = list[Array](), robot.integration.h
    for simulator in carry(robot):
        now.append(cube(simulator))
        if len(now) - 1 == round(TOP / h):
            print(f"at the top the fingers carry {grip(simulator)[2] / weight:.4f} of the weight")
            np.testing.assert_allclose(grip(simulator), [0.0, 0.0, weight], atol=0.01 * weight)
    way = now[-1].mean(axis=0) - now[0].mean(axis=0)
    print(f"put down {1e3 * way[0]:.1f} mm from where it was, upside down")
    before, after = (places - places.mean(axis=0) for places in (now[0], now[-1]))
    np.testing.assert_allclose(after, before * [-1.0, 1.0, -1.0], atol=1e-3)
    assert grip(simulator)[2] == 0.0
    assert abs(way[2]) < 1e-4


if __name__ == "__main__":
    main()
