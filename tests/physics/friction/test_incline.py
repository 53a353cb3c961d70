"""Cubes on an incline: they stick below the angle of friction and slide above it."""

from __future__ import annotations

import numpy as np
import pytest
from support.robots.bodies import beam_config, box_mesh

from tauten.model import Robot, Simulator, State
from tauten.model.load import build_robot
from tauten.model.schema import RobotConfig, validated

SIDE, G, DENSITY, RATE = 0.02, 9.81, 1000.0, 200.0
WEIGHT = DENSITY * SIDE**3 * G  # N


def cube(angle_deg: float, friction: float, **body: object) -> Robot:
    """A cube on the plane z = 0 in a gravity that is tilted towards x."""
    angle = np.deg2rad(angle_deg)
    bodies = [{"name": "cube", "mesh": {"file": "cube.vtu"}, "free": True, **body}]
    settings = beam_config(
        (SIDE, SIDE, SIDE), mesh=None, fixed=[], bodies=bodies,
        gravity=[G * np.sin(angle), 0.0, -G * np.cos(angle)],
        material={"young_modulus": 1e5, "poisson_ratio": 0.3, "density": DENSITY},
        integration={"rayleigh_mass": 0.0, "rayleigh_stiffness": 0.002},
        controller={"rate": RATE},
        regions=[{"name": "below", "kind": "normal", "body": "cube", "direction": [0, 0, -1]}],
        obstacles=[
            {"name": "floor", "shape": "plane",
             "parameters": {"point": [0.0, 0.0, 0.0], "normal": [0.0, 0.0, 1.0]}}
        ],
        effectors=[{"name": "centre", "point": [0.5 * SIDE] * 3}],
        contacts=[
            {"candidates": "below", "against": "floor", "points": "vertices", "friction": friction}
        ],
    )  # fmt: skip
    known = {key: value for key, value in settings.items() if value is not None}
    mesh = box_mesh((SIDE, SIDE, SIDE), (2, 2, 2))
    return build_robot(validated(RobotConfig, known, "robot.toml"), [mesh], "robot.toml")


def moved(simulator: Simulator, steps: int) -> np.ndarray:
    """How far the centre moves in some time steps without effort [m]."""
    robot, start = simulator.robot, simulator.tip
    for _ in range(steps):
        assert simulator.move(effort=np.zeros(robot.n_a)).converged
    return simulator.tip - start


@pytest.mark.long
@pytest.mark.parametrize("rigid", [True, False])
@pytest.mark.parametrize("angle", [20.0, 30.0])
def test_a_cube_sticks_below_the_angle_of_friction_and_slides_above_it(
    rigid: bool, angle: float
) -> None:
    """The angle is 25°; above it a = g (sin − μ cos), and the force is at the border of the cone."""
    mu, a = np.tan(np.deg2rad(25.0)), np.deg2rad(angle)
    simulator = Simulator(cube(angle, mu, rigid=rigid))
    moved(simulator, 30)  # a soft one is in motion at first
    first, second = (moved(simulator, 20) for _ in range(2))
    acceleration = (second - first)[0] / (20 / RATE) ** 2
    contacts = simulator.contacts
    force = contacts.force.sum(axis=0)
    np.testing.assert_allclose(force[2], WEIGHT * np.cos(a), rtol=1e-3)
    if angle < 25.0:
        assert abs(second[0]) < 1e-6
        assert not contacts.sliding[contacts.pushing].all()
        np.testing.assert_allclose(force[0], -WEIGHT * np.sin(a), rtol=1e-3)
    else:
        expected = G * (np.sin(a) - mu * np.cos(a))
        np.testing.assert_allclose(acceleration, expected, rtol=2e-3)
        assert contacts.sliding[contacts.pushing].all() and not contacts.margin.any()
        np.testing.assert_allclose(force[0], -mu * force[2], rtol=1e-6)


def test_friction_only_takes_energy_and_stops_a_cube_where_coulomb_has_it() -> None:
    """Way v² / (2 μ g), in steps of implicit Euler less by v h / 2; converged steps gain no energy."""
    mu, speed = 0.4, 0.3
    robot = cube(0.0, mu)
    simulator, still = Simulator(robot), np.zeros(robot.n_a)
    moved(simulator, 60)  # sagged
    state = simulator.state
    x0, v0 = simulator.tip, state.v.copy()
    v0[0::3] += speed
    simulator.start_from(State(state.q, v0, state.memory), simulator.forces)
    energies = [robot.energy(simulator.state)]
    for _ in range(round(1.3 * RATE * speed / (mu * G))):
        assert simulator.step(effort=still, converged=True).converged
        energies.append(robot.energy(simulator.state))
        certificate = simulator.certificate
        assert certificate is not None and certificate.work <= 1e-12
    assert np.diff(energies).max() <= 1e-9 * energies[0]
    way = (simulator.tip - x0)[0]
    expected = speed**2 / (2.0 * mu * G) - 0.5 * speed / RATE
    np.testing.assert_allclose(way, expected, rtol=0.01)
    lost = (energies[0] - energies[-1]) / (0.5 * DENSITY * SIDE**3 * speed**2)
    np.testing.assert_allclose(lost, 1.0, rtol=0.05)
    assert np.abs(simulator.state.v).max() < 0.02 * speed
