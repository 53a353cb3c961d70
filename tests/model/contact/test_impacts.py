"""An impact with an obstacle leaves the velocity of the obstacle, and no more, however a step is divided."""

from __future__ import annotations

import numpy as np
import pytest
from support.robots.blocks import block

from tauten.model import Simulator

G = 9.81
SPEED = 0.5  # m/s, of the plate
KINDS = {"rigid": (True, 1e5), "soft": (False, 1e5), "very soft": (False, 2e4)}  # modulus in Pa


def above_plate(kind: str, rate: float, gap: float) -> Simulator:
    """A block at a height above a plate [m]."""
    rigid, young = KINDS[kind]
    plate = {"lower": [-0.1, -0.1, -0.02], "upper": [0.1, 0.1, 0.0]}
    robot = block(
        bodies=[{"name": "cube", "mesh": {"file": "cube.vtu"}, "free": True, "rigid": rigid}],
        material={"young_modulus": young, "poisson_ratio": 0.3, "density": 1000.0},
        obstacles=[{"name": "floor", "shape": "box", "parameters": plate, "position": [0.0, 0.0, -gap]}],
        controller={"rate": rate},
    )  # fmt: skip
    return Simulator(robot, "full")


def height(simulator: Simulator) -> float:
    """Of the middle of the block [m]."""
    return float(simulator.effector[0][2])


def speed(simulator: Simulator) -> float:
    """Of the middle of the block, upwards [m/s]."""
    robot, state, seconds = simulator.robot, simulator.state, 1e-6
    after = robot.advance(state, state.v, seconds)
    return float((robot.effector(after) - robot.effector(state))[0][2] / seconds)


def above(simulator: Simulator) -> float:
    """Height of the lowest point of the block above the plate [m]."""
    plate = simulator.obstacles.poses[0].position[2]
    return float(simulator.robot.candidates(simulator.state)[:, 2].min() - plate)


@pytest.mark.long
@pytest.mark.parametrize(  # any two of the three in all combinations
    ("kind", "rate", "gap", "then"),
    [  # m, m/s: on the plate, which then stops; above it, and it goes back
        (kind, rate, *((0.0, 0.0), (0.0037, -0.2))[(i + k) % 2])
        for i, kind in enumerate(KINDS)
        for k, rate in enumerate((50.0, 200.0))
    ],
)
def test_a_block_has_the_velocity_of_a_plate_that_hits_it_and_flies_as_high_as_that_leads(
    kind: str, rate: float, gap: float, then: float
) -> None:
    """By hand: v without elasticity, and where the plate stops v t − g t² / 2, at most v² / 2 g = 12.7 mm."""
    simulator = above_plate(kind, rate, gap)
    if gap > 0.0:  # it floats until the plate comes
        simulator.load([0.0] * 3, [0.0] * 3)
    for _ in range(round(0.06 * rate)):
        simulator.move(effort=[0.0])
    simulator.place("floor", [0.0, 0.0, -gap], velocity=[0.0, 0.0, SPEED])
    for _ in range(round(0.06 * rate)):
        simulator.move(effort=[0.0])
        assert speed(simulator) < 1.01 * SPEED
    assert speed(simulator) == pytest.approx(SPEED, rel=5e-3)
    assert abs(above(simulator)) < 5e-5
    simulator.load([0.0, 0.0, -G], [0.0] * 3)
    top = simulator.obstacles.poses[0].position
    simulator.place("floor", top, velocity=[0.0, 0.0, then])
    start, heights = height(simulator), []
    for _ in range(round(0.1 * rate)):
        simulator.move(effort=[0.0])
        heights.append(height(simulator) - start)
    t = np.arange(1, len(heights) + 1) / rate
    np.testing.assert_allclose(heights, SPEED * t - 0.5 * G * t * t, atol=2e-4)
    assert max(heights) < 1.01 * SPEED**2 / (2.0 * G)


@pytest.mark.long
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("fall", [0.011, 0.012, 0.017])  # m
def test_a_block_that_falls_on_a_plate_does_not_rebound(kind: str, fall: float) -> None:
    """By hand: of rigid bodies nothing remains; the soft ones are damped far beyond their vibration."""
    rate = 200.0
    simulator = above_plate(kind, rate, fall)
    for _ in range(round(rate * np.sqrt(2.0 * fall / G)) + 2):
        simulator.move(effort=[0.0])
    assert above(simulator) < 1e-5
    for _ in range(20):
        simulator.move(effort=[0.0])
        assert above(simulator) < 1e-5
    assert abs(speed(simulator)) < 1e-3
