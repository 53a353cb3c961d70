"""Rigid bodies: one that rolls, one that is wedged between two walls, and what friction does to energy."""

from __future__ import annotations

import numpy as np
import pytest
from support.robots.bodies import beam_config, box_mesh

from tauten.model import Robot, Simulator
from tauten.model.load import build_robot
from tauten.model.mesh import TetMesh, checked
from tauten.model.schema import RobotConfig

G, DENSITY = 9.81, 1000.0
RADIUS, WIDTH, SIDES = 0.02, 0.01, 400


def free_body(
    mesh: TetMesh, gravity: list[float], walls: dict[str, tuple[list[float], list[float]]],
    friction: float, rate: float, facing: float,
) -> Robot:  # fmt: skip
    """A body that nothing holds between walls, each a point and a normal; its vertices touch them."""
    settings = beam_config(
        (0.02, 0.02, 0.02), mesh=None, fixed=[], gravity=gravity, controller={"rate": rate},
        bodies=[{"name": "body", "mesh": {"file": "body.vtu"}, "free": True, "rigid": True}],
        material={"young_modulus": 1e5, "poisson_ratio": 0.3, "density": DENSITY},
        effectors=[{"name": "centre", "point": mesh.nodes.mean(axis=0).tolist()}],
        cables=[{"name": "none", "points": mesh.nodes[mesh.tets[0][:2]].tolist(), "max_tension": 1.0,
                 "max_pull": 0.01, "max_rate": 1.0}],
        obstacles=[
            {"name": name, "shape": "plane", "parameters": {"point": point, "normal": normal}}
            for name, (point, normal) in walls.items()
        ],
        regions=[{"name": "below", "kind": "normal", "body": "body", "direction": [0.0, 0.0, -1.0],
                  "max_angle_deg": facing}],
        contacts=[
            {"candidates": "below", "against": name, "points": "vertices", "friction": friction}
            for name in walls
        ],
    )  # fmt: skip
    known = {key: value for key, value in settings.items() if value is not None}
    return build_robot(RobotConfig.model_validate(known), [mesh], "body")


def roller() -> TetMesh:
    """A cylinder about the axis y that stands on z = 0, of so many sides that its corners hardly matter."""
    angle = 2.0 * np.pi * np.arange(SIDES) / SIDES
    ring = np.stack([RADIUS * np.sin(angle), 0.0 * angle, RADIUS * (1.0 - np.cos(angle))], axis=1)
    centre, width = np.array([0.0, 0.0, RADIUS]), np.array([0.0, WIDTH, 0.0])
    nodes = np.vstack([ring, ring + width, centre, centre + width])
    i = np.arange(SIDES)
    j, a, b = (i + 1) % SIDES, np.full(SIDES, 2 * SIDES), np.full(SIDES, 2 * SIDES + 1)
    prisms = [(a, i, j, b), (i, j, b, j + SIDES), (i, j + SIDES, b, i + SIDES)]
    tets = np.concatenate([np.stack(one, axis=1) for one in prisms])
    edges = nodes[tets[:, 1:]] - nodes[tets[:, :1]]
    turned = np.linalg.det(edges) < 0.0
    tets[turned] = tets[turned][:, [0, 2, 1, 3]]
    return checked(nodes, tets, "roller")


@pytest.mark.parametrize(("friction", "rolls"), [(0.5, True), (0.08, False)])
def test_a_cylinder_rolls_down_an_incline_or_slides_where_friction_is_too_small(
    friction: float, rolls: bool
) -> None:
    """With I = k m R², k = ½: g sin / (1 + k) where μ ≥ tan k / (1 + k), and g (sin − μ cos) below it."""
    angle, k = np.deg2rad(20.0), 0.5
    gravity = [G * np.sin(angle), 0.0, -G * np.cos(angle)]
    floor = {"floor": ([0.0, 0.0, 0.0], [0.0, 0.0, 1.0])}
    simulator, steps = Simulator(free_body(roller(), gravity, floor, friction, 500.0, 20.0)), 30
    for _ in range(steps):
        assert simulator.move(effort=[0.0]).converged
    normal = G * np.cos(angle)
    expected = G * np.sin(angle) / (1.0 + k) if rolls else G * np.sin(angle) - friction * normal
    spin = expected / RADIUS if rolls else friction * normal / (k * RADIUS)
    v = simulator.state.v / (steps / 500.0)
    np.testing.assert_allclose(v[[0, 4]], [expected, spin], rtol=0.01)
    certificate = simulator.certificate
    assert certificate is not None and certificate.work <= 1e-15
    assert certificate.sticking.any() == rolls


@pytest.mark.parametrize("friction", [0.2, 0.34, 0.38, 0.6])
def test_a_wedge_between_two_walls_is_indeterminate_and_jams_below_the_angle_of_friction(
    friction: float,
) -> None:
    """Half angle 20°, tan θ = 0.364: forces in the cones hold each other exactly where tan θ < μ."""
    theta, side = np.deg2rad(20.0), 0.02
    mesh = box_mesh((side, side, side), (1, 1, 1))
    nodes = mesh.nodes - [0.5 * side, 0.0, 0.0]
    nodes[:, 0] *= 1.0 + 2.0 * np.tan(theta) * nodes[:, 2] / side
    body = checked(nodes, mesh.tets, "wedge")
    wall, point = [float(np.cos(theta)), 0.0, float(np.sin(theta))], 0.5 * side
    walls = {
        "left": ([-point, 0.0, 0.0], wall),
        "right": ([point, 0.0, 0.0], [-wall[0], 0.0, wall[2]]),
    }
    simulator = Simulator(free_body(body, [0.0, 0.0, -G], walls, friction, 200.0, 180.0))
    for _ in range(5):
        assert simulator.move(effort=[0.0]).converged
    weight = DENSITY * side**3 * (1.0 + np.tan(theta)) * G
    np.testing.assert_allclose(simulator.contact_forces.sum(axis=0), [0, 0, weight], atol=1e-4)
    certificate = simulator.certificate
    assert certificate is not None and certificate.indeterminate
    assert certificate.jammed == (np.tan(theta) < friction)
