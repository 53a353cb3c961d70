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
from support.robots.bodies import box_mesh

from tauten.model import Robot, Simulator
from tauten.model.mesh import TetMesh
from tauten.model.numerics import Array

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


@pytest.mark.long
@pytest.mark.parametrize(  # Hz, m/s, m: up to 5 times the edge of the cubes in a step
    ("rate", "speed", "gap", "friction"),
    [  # of rate with speed, gap and friction any two in all combinations
        (rate, speed, gap, 0.5 * ((i + k) % 2))
        for i, (rate, speed) in enumerate([(50.0, 1.0), (200.0, 5.0), (50.0, 5.0)])
        for k, gap in enumerate([0.002, 0.012, 0.037, 0.06])
    ],
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
    assert separation(simulator) == pytest.approx(EDGE, abs=5e-4)


def test_cubes_that_meet_beside_their_centres_turn_as_one() -> None:
    """By hand: m v e / 2 is the moment of momentum, and 2 m a² / 6 + 2 m (a / 2)² the inertia of both."""
    simulator, speed = thrown(two_cubes(800.0, 0.002, 0.0), 5.0), 5.0
    for _ in range(4):
        assert simulator.move(effort=[0.0]).converged
    turn = 0.5 * speed / (EDGE**2 * (1.0 / 3.0 + 0.5)) * np.array([0.0, -2e-4, 1e-4])
    np.testing.assert_allclose(simulator.state.v[[3, 4, 5]], turn, atol=0.02 * np.abs(turn).max())
    np.testing.assert_allclose(simulator.state.v[[9, 10, 11]], turn, atol=0.02 * np.abs(turn).max())


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


@pytest.mark.long
def test_a_cube_that_is_thrown_at_a_soft_beam_bounces_back() -> None:
    """20 cm in a step; what the cube loses is in the beam, which is clamped below."""
    side, height, rate, speed = 0.015, 0.1, 50.0, 10.0
    beam, start = box_mesh((side, side, height), (2, 2, 8)), (0.04, 0.001, 0.06)
    below = {"kind": "box", "lower": [-1.0, -1.0, -1e-3], "upper": [1.0, 1.0, 1e-3]}
    robot = free_bodies(
        {"cube": box((side,) * 3, start), "beam": beam},
        [touching("cube", "beam", friction=0.5), touching("beam", "cube", friction=0.5)],
        rate,
        bodies=[
            {"name": "body_cube", "mesh": {"file": "cube.vtu"}, "free": True, "rigid": True},
            {"name": "body_beam", "mesh": {"file": "beam.vtu"}, "fixed": [below]},
        ],
        material={"young_modulus": 4e5, "poisson_ratio": 0.45, "density": 1000.0},
        contact={"alarm_distance": 3e-3},
    )
    v = np.zeros(robot.n)
    v[-6] = -speed
    simulator = moving(robot, v)
    energy = robot.energy(simulator.state)
    for _ in range(round(rate * 0.06 / speed) + 6):
        assert simulator.move(effort=[0.0]).converged
        assert robot.energy(simulator.state) < energy * (1.0 + 1e-6)
        assert simulator.effector[0, 0] > -0.5 * height
    assert velocities(simulator)[0, 0] > 0.0


@pytest.mark.parametrize("friction", [0.0, 0.5])
@pytest.mark.parametrize("spin", [20.0, 60.0])  # rad/s
def test_a_bar_that_spins_hits_a_cube_and_momentum_and_its_moment_stay(
    spin: float, friction: float
) -> None:
    """By hand: the bar and the cube have the same mass, and rest in the middle of both."""
    bar = box((0.08, 0.01, 0.01), (-0.04, -0.005, -0.005))
    cube = box((EDGE, EDGE, EDGE), (0.02, 0.02, -0.01))
    bodies = {"one": bar, "other": cube}
    contacts = [
        touching("one", "other", friction=friction),
        touching("other", "one", friction=friction),
    ]
    robot = free_bodies(bodies, contacts, 50.0)
    v = np.zeros(12)
    v[5] = spin
    simulator = moving(robot, v)

    def moment() -> Array:
        """Of the momentum of both bodies about the origin, for a density of one (3,)."""
        total = np.zeros(3)
        state, seconds = simulator.state, 1e-7
        x = robot.motion(state).x
        moved = (robot.motion(robot.advance(state, state.v, seconds)).x - x) / seconds
        for mesh, first in ((bar, 0), (cube, len(bar.nodes))):
            r, v = x[first + mesh.tets], moved[first + mesh.tets]  # (e, 4, 3)
            own = np.cross(r, v).sum(axis=1) + np.cross(r.sum(axis=1), v.sum(axis=1))
            total += mesh.volumes @ own / 20.0
        return total

    before, energy = moment(), robot.energy(simulator.state)
    for _ in range(round(0.3 * 50.0)):
        assert simulator.move(effort=[0.0]).converged
        assert robot.energy(simulator.state) < energy * (1.0 + 1e-9)
    assert robot.energy(simulator.state) < 0.7 * energy  # they have met
    np.testing.assert_allclose(velocities(simulator).sum(axis=0), 0.0, atol=1e-6 * spin)
    np.testing.assert_allclose(moment(), before, atol=0.01 * np.linalg.norm(before))
