"""Bodies thrown at each other and at soft ones: none passes, momentum stays, energy does not grow."""

from __future__ import annotations

import numpy as np
import pytest
from support.robots.blocks import (
    box,
    free_bodies,
    moving,
    separation,
    speeds,
    touching,
    velocities,
)

from tauten.model import Robot, Simulator
from tauten.model.mesh import TetMesh

EDGE = 0.02


def two_cubes(rate: float, gap: float, friction: float, rigid: bool = True) -> Robot:
    """Two cubes, one behind the other along x, nearly in line."""
    cube = (EDGE, EDGE, EDGE)
    bodies = {"one": box(cube, (0.0, 0.0, 0.0)), "other": box(cube, (EDGE + gap, 1e-4, 2e-4))}
    contacts = [
        touching("one", "other", friction=friction),
        touching("other", "one", friction=friction),
    ]
    return free_bodies(bodies, contacts, rate, rigid)


def thrown(robot: Robot, speed: float) -> Simulator:
    """The first body with a speed along x."""
    if robot.n == 12:
        return moving(robot, speeds(2, np.array([speed, 0.0, 0.0])))
    v = np.zeros(robot.n)
    v[: robot.n // 2 : 3] = speed
    return moving(robot, v)


@pytest.mark.parametrize("friction", [0.0, 0.5])
@pytest.mark.parametrize("gap", [0.002, 0.012, 0.037, 0.06])  # m
@pytest.mark.parametrize(  # Hz, m/s: up to 5 times the edge of the cubes in a step
    ("rate", "speed"), [(50.0, 1.0), (200.0, 5.0), (50.0, 5.0)]
)
def test_a_cube_that_hits_another_one_goes_on_with_it(
    rate: float, speed: float, gap: float, friction: float
) -> None:
    """By hand: v / 2 of equal masses without elasticity, and all of the momentum."""
    simulator = thrown(two_cubes(rate, gap, friction), speed)
    energy = simulator.robot.energy(simulator.state)
    for _ in range(int(rate * gap / speed) + 3):
        assert simulator.move(effort=[0.0]).converged
        assert simulator.robot.energy(simulator.state) < energy * (1.0 + 1e-9)
    found = velocities(simulator)
    np.testing.assert_allclose(found.sum(axis=0), [speed, 0.0, 0.0], atol=1e-6 * speed)
    np.testing.assert_allclose(found[:, 0], 0.5 * speed, rtol=0.02)
    assert separation(simulator) == pytest.approx(EDGE, abs=3e-4)


@pytest.mark.parametrize("speed", [1.0, 5.0, 20.0])
def test_a_single_step_does_not_lead_a_cube_through_another_one(speed: float) -> None:
    simulator = thrown(two_cubes(50.0, 0.005, 0.0), speed)
    for _ in range(3):
        assert simulator.step(effort=[0.0]).converged
    assert separation(simulator) == pytest.approx(EDGE, abs=0.15 * EDGE)
    np.testing.assert_allclose(velocities(simulator)[:, 0], 0.5 * speed, rtol=0.02)


@pytest.mark.parametrize("speed", [1.0, 5.0])
def test_of_soft_cubes_that_collide_none_passes_and_the_other_one_takes_momentum(
    speed: float,
) -> None:
    simulator = thrown(two_cubes(50.0, 0.037, 0.0, rigid=False), speed)
    energy = simulator.robot.energy(simulator.state)
    for _ in range(6):
        simulator.move(effort=[0.0])
        assert simulator.robot.energy(simulator.state) < energy * (1.0 + 1e-9)
    found = velocities(simulator)
    assert found[:, 0].sum() == pytest.approx(speed, rel=1e-6)
    assert found[1, 0] >= found[0, 0] - 1e-3 * speed
    assert separation(simulator) > 0.9 * EDGE


def test_a_cube_that_flies_past_a_corner_of_another_one_is_not_held() -> None:
    """It misses the other one by 0.5 mm, with five edges in a step."""
    cube = (EDGE, EDGE, EDGE)
    bodies = {
        "one": box(cube, (0.0, 0.0, 0.0)),
        "other": box(cube, (EDGE + 0.037, EDGE + 5e-4, 0.0)),
    }
    contacts = [touching("one", "other"), touching("other", "one")]
    simulator = thrown(free_bodies(bodies, contacts, 50.0), 5.0)
    for _ in range(3):
        simulator.move(effort=[0.0])
    np.testing.assert_allclose(velocities(simulator)[0], [5.0, 0.0, 0.0], atol=1e-9)


@pytest.mark.parametrize("ratio", [1e-5, 1e5])
def test_a_cube_hits_one_of_a_hundred_thousand_times_its_mass(ratio: float) -> None:
    """By hand: m v / (m + M), of which the lighter one gets all."""
    big, small = EDGE * 1e5 ** (1 / 3), EDGE
    sizes = (big, small) if ratio < 1.0 else (small, big)
    meshes: list[TetMesh] = []
    for edge, x in zip(sizes, (-sizes[0], 0.005), strict=True):
        meshes.append(box((edge, edge, edge), (x, -0.5 * edge, -0.5 * edge)))
    contacts = [touching("one", "other"), touching("other", "one")]
    robot = free_bodies(dict(zip(("one", "other"), meshes, strict=True)), contacts, 100.0)
    simulator = thrown(robot, 2.0)
    for _ in range(3):
        assert simulator.move(effort=[0.0]).converged
    np.testing.assert_allclose(velocities(simulator)[:, 0], 2.0 / (1.0 + ratio), rtol=1e-4)
