"""Obstacles: distances of the shapes, and forces and motions that are known."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.robots.beam_robots import build, path_of_beams, rectangle
from support.robots.blocks import BELOW, block, force_on
from support.robots.bodies import CABLE
from support.robots.small_bodies import small_body

from tauten.model import (
    Command,
    Robot,
    RobotFileError,
    Simulator,
    default_enrichment,
    no_forces,
)
from tauten.model.contact import SHAPES, ContactPair, ContactSet, Obstacle, Shape, pose_at
from tauten.model.contact.shapes import DrawnShape
from tauten.model.numerics import Array
from tauten.model.simulation.relaxation import relaxed
from tauten.reduction.campaign import ramp
from tauten.reduction.contact import ReduceSettings, reduce_robot
from tauten.service.check.contact_findings import thin_walls

FLOOR = {"point": [0.0, 0.0, 0.0], "normal": [0.0, 0.0, 1.0]}
g = 9.81

KNOWN: dict[str, tuple[dict[str, Any], Array, list[float], Array]] = {
    "plane": (
        {"point": [0.0, 0.0, 1.0], "normal": [0.0, 3.0, 4.0]},
        np.array([[5.0, 0.0, 2.0], [0.0, -1.0, 1.0], [1.0, 4.0, -2.0]]),
        [0.8, -0.6, 0.0],
        np.tile([0.0, 0.6, 0.8], (3, 1)),
    ),
    "sphere": (
        {"centre": [1.0, 0.0, 0.0], "radius": 2.0},
        np.array([[1.0, 0.0, 3.0], [0.0, 0.0, 0.0], [4.0, 4.0, 0.0]]),
        [1.0, -1.0, 3.0],
        np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.6, 0.8, 0.0]]),
    ),
    "capsule": (
        {"start": [0.0, 0.0, 0.0], "end": [4.0, 0.0, 0.0], "radius": 0.5},
        np.array([[2.0, 0.0, 2.0], [-3.0, 4.0, 0.0], [7.0, 0.0, 4.0], [1.0, 0.2, 0.0]]),
        [1.5, 4.5, 4.5, -0.3],
        np.array([[0.0, 0.0, 1.0], [-0.6, 0.8, 0.0], [0.6, 0.0, 0.8], [0.0, 1.0, 0.0]]),
    ),
    "cylinder": (
        {"start": [0.0, 0.0, -1.0], "end": [0.0, 0.0, 3.0], "radius": 2.0},
        np.array(
            [[0.0, 5.0, 0.0], [5.0, 0.0, 7.0], [0.0, 0.5, 2.9], [0.0, 1.9, 1.0], [1.0, 0.0, -4.0]]
        ),
        [3.0, 5.0, -0.1, -0.1, 3.0],
        np.array(
            [[0.0, 1.0, 0.0], [0.6, 0.0, 0.8], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]
        ),
    ),
    "box": (
        {"lower": [-1.0, -1.0, -1.0], "upper": [3.0, 1.0, 1.0]},
        np.array(
            [[0.0, 3.0, 0.0], [6.0, 0.0, 5.0], [0.0, 0.0, -0.8], [-4.0, 5.0, 0.5], [3.0, 0.0, 0.0]]
        ),
        [2.0, 5.0, -0.2, 5.0, 0.0],
        np.array(
            [[0.0, 1.0, 0.0], [0.6, 0.0, 0.8], [0.0, 0.0, -1.0], [-0.6, 0.8, 0.0], [1.0, 0.0, 0.0]]
        ),
    ),
}


def shape(name: str, parameters: dict[str, Any]) -> Shape:
    """A shape with the parameters of a robot file."""
    arrays = {
        key: np.array(value) if isinstance(value, list) else value
        for key, value in parameters.items()
    }
    found: Shape = SHAPES[name](**arrays)
    return found


@pytest.mark.parametrize("name", SHAPES)
def test_distances_and_normals_are_known(name: str) -> None:
    parameters, points, gaps, normals = KNOWN[name]
    gap, normal = shape(name, parameters).closest(points)
    np.testing.assert_allclose(gap, gaps, atol=1e-12)
    np.testing.assert_allclose(normal, normals, atol=1e-12)


@pytest.mark.parametrize("name", SHAPES)
def test_normals_are_gradients(name: str) -> None:
    one = shape(name, KNOWN[name][0])
    points, step = 3.0 * np.random.default_rng(0).normal(size=(20, 3)), 1e-6
    _, normal = one.closest(points)
    for k, axis in enumerate(np.eye(3)):
        up, down = (one.closest(points + by * axis)[0] for by in (step, -step))
        np.testing.assert_allclose(normal[:, k], (up - down) / (2.0 * step), atol=1e-6)


def test_pairs_of_both_kinds_have_their_slots() -> None:
    """A shape between two pairs of surfaces: slots ascend, and what is out of range has none."""
    x = np.array(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 0.5], [1, 0, 0.5], [0, 1, 0.5]], dtype=float
    )
    lower, upper = np.array([[0, 1, 2]]), np.array([[3, 4, 5]])
    centre = np.full((1, 3), 1.0 / 3.0)
    none = np.zeros((0, 3), dtype=np.int64)
    corners = np.eye(3)
    floor = shape("plane", {"point": [0.0, 0.0, -0.25], "normal": [1.0, 0.0, 1.0]})
    obstacle = Obstacle("floor", floor, pose_at())
    contacts = ContactSet(
        [
            ContactPair("one", upper, centre, lower),
            ContactPair("floor", np.tile(lower, (3, 1)), corners, none, obstacle=obstacle),
            ContactPair("other", upper, centre, lower),
        ],
        len(x), alarm_distance=0.6, distance=0.01,
    )  # fmt: skip
    found = contacts.detect(x)
    assert [one.name for one in contacts.pair_slots] == ["one", "floor", "other"]
    assert found.slots.tolist() == [0, 1, 3, 4]
    assert found.pair.tolist() == [0, 1, 1, 2]
    np.testing.assert_allclose(found.gap, [0.49, 0.25 / 2**0.5 - 0.01, 0.25 / 2**0.5 - 0.01, 0.49])
    np.testing.assert_allclose(found.point[1:3], x[[0, 2]])
    x[2] = np.nan  # a corner of all of them
    assert contacts.detect(x).slots.tolist() == []


def test_obstacles_have_no_walls_to_check() -> None:
    assert thin_walls(block(), 1.0).found == "all contacts are with obstacles"


def test_a_floor_carries_the_weight_of_a_block() -> None:
    simulator = Simulator(block(), "full")
    for _ in range(100):
        simulator.step(effort=[0.0])
    weight = 1000.0 * 0.02**3 * g
    np.testing.assert_allclose(force_on(simulator), [0.0, 0.0, weight], rtol=1e-6, atol=1e-9)
    assert simulator.robot.rows(simulator.state).contacts.rows.delta == pytest.approx(0.0, abs=1e-9)


def test_a_block_slides_down_with_g_sin() -> None:
    """Without friction it accelerates along the floor, which carries m g cos α across."""
    alpha, steps = 0.3, 50
    gravity = [g * np.sin(alpha), 0.0, -g * np.cos(alpha)]
    simulator = Simulator(block(gravity=gravity), "full")
    start, h = simulator.effector[0].copy(), simulator.robot.h
    for _ in range(steps):
        simulator.step(effort=[0.0])
    # implicit Euler: positions follow the velocities at the ends of the steps
    expected = g * np.sin(alpha) * h**2 * steps * (steps + 1) / 2.0
    assert simulator.effector[0][0] - start[0] == pytest.approx(expected, rel=1e-6)
    across = 1000.0 * 0.02**3 * g * np.cos(alpha)
    np.testing.assert_allclose(force_on(simulator), [0.0, 0.0, across], rtol=1e-4, atol=1e-9)


def propped(folder: Path, below: float, thickness: float = np.inf) -> Robot:
    """A slender beam along x under its weight, clamped at x = 0, its tip above a floor at a distance [m]."""
    floor: dict[str, Any] = {
        "name": "floor",
        "shape": "plane",
        "parameters": {"point": [0.0, 0.0, -below], "normal": [0.0, 0.0, 1.0]},
    }
    if thickness < np.inf:
        lower, upper = [0.5, -1.0, -below - thickness], [1.5, 1.0, -below]
        floor = {"name": "floor", "shape": "box", "parameters": {"lower": lower, "upper": upper}}
    nodes = np.outer(np.linspace(0.0, 1.0, 33), [1.0, 0.0, 0.0])
    beams = path_of_beams(nodes, (0.0, 0.0, 1.0), "bar")
    profile = rectangle("bar", 0.02, 0.01)
    return build(
        folder, nodes, beams, [profile], (1e9, 0.3, 1000.0), [0], 32,
        gravity=[0.0, 0.0, -1.0],
        contacts=[{"candidates": "foot", "against": "floor", "points": 1}],
        obstacles=[floor],
        surfaces=[{"name": "foot", "nodes": [32, 32, 32],
                   "points": [[1.001, 0.0, 0.0], [0.9995, 1e-3, 0.0], [0.9995, -1e-3, 0.0]],
                   "triangles": [[0, 2, 1]]}],
    )  # fmt: skip


def reaction(below: float) -> float:
    """R = 3/8 q L − 3 E I d / L³ where the prop is d below, of Euler and Bernoulli [N]."""
    q, EI = 1000.0 * 0.02 * 0.01 * 1.0, 1e9 * 0.02 * 0.01**3 / 12.0
    return 0.375 * q - 3.0 * EI * below


@pytest.mark.parametrize("below, thickness", [(0.0, np.inf), (2e-3, np.inf), (2e-3, 1e-3)])
def test_a_propped_cantilever_has_the_reaction_of_the_textbook(
    tmp_path: Path, below: float, thickness: float
) -> None:
    """Without the prop the tip would be 15 mm lower, far below the thin one."""
    simulator = Simulator(propped(tmp_path, below, thickness), "full")
    assert simulator.settle(position=[-0.5], tolerance=1e-12).converged
    expected = [0.0, 0.0, reaction(below)]
    np.testing.assert_allclose(force_on(simulator), expected, rtol=2e-3, atol=1e-9)


def test_a_cantilever_that_relaxes_in_time_comes_to_rest_on_a_thin_prop(tmp_path: Path) -> None:
    robot = propped(tmp_path, 2e-3, 1e-3)
    simulator, enrichment = Simulator(robot, "full"), default_enrichment(robot.tolerance)
    slack, none = Command.of(np.array([-0.5]), None), no_forces(1, simulator.space.k)
    found = relaxed(robot, simulator.space, enrichment, robot.rest(), none, slack)
    simulator.start_from(*found)
    simulator.settle(position=[-0.5], tolerance=1e-12)
    np.testing.assert_allclose(force_on(simulator), [0.0, 0.0, reaction(2e-3)], rtol=2e-3)


@pytest.mark.long
def test_a_contact_basis_is_made_with_an_obstacle(tmp_path: Path) -> None:
    """`tauten reduce`: a beam that is pulled onto a ball; with the basis it comes to rest as without."""
    ball = {
        "name": "ball",
        "shape": "sphere",
        "parameters": {"centre": [0.09, 0.01, -0.012], "radius": 0.01},
    }
    robot = small_body(
        "linear", surfaces=[BELOW], obstacles=[ball], cables=[{**CABLE, "max_pull": 6e-3}],
        contacts=[{"candidates": "below", "against": "ball", "points": "vertices"}],
    )  # fmt: skip
    design = ramp(robot, step=2e-4)
    result = reduce_robot(robot, design, tmp_path, ReduceSettings(k=2))
    assert result.basis.k == 2
    pulled = [Simulator(robot, contact) for contact in ("full", result.basis, "none")]
    for simulator in pulled:
        assert simulator.settle(position=[5e-3]).converged
    tips = [simulator.effector[0] for simulator in pulled]
    assert np.linalg.norm(tips[0] - tips[2]) > 1e-3
    np.testing.assert_allclose(tips[1], tips[0], atol=5e-5)
    lowest = pulled[0].robot.candidates(pulled[0].state) - ball["parameters"]["centre"]  # type: ignore[index]
    assert np.linalg.norm(lowest, axis=1).min() == pytest.approx(0.01, abs=5e-5)


REFUSED: dict[str, dict[str, Any]] = {
    "floor.parameters: 'height' is not one of them; allowed are: point, normal": {
        "parameters": {**FLOOR, "height": 1.0}
    },
    "floor.parameters: normal: [0.0, 0.0, 0.0] has no direction": {
        "parameters": {"point": [0.0, 0.0, 0.0], "normal": [0.0, 0.0, 0.0]}
    },
    "floor.parameters: radius: found -1.0, expected a positive number": {
        "shape": "sphere", "parameters": {"centre": [0.0, 0.0, 0.0], "radius": -1.0}
    },
    "floor.parameters: end: coincides with start": {
        "shape": "capsule", "parameters": {"start": [0.0, 0.0, 0.0], "end": [0.0, 0.0, 0.0], "radius": 1.0}
    },
    "floor.parameters: upper: [0.0, 1.0, 1.0] must be larger than lower": {
        "shape": "box", "parameters": {"lower": [0.0, 0.0, 0.0], "upper": [0.0, 1.0, 1.0]}
    },
    "floor.parameters: centre: expected three numbers [m], found [0.0, 0.0]": {
        "shape": "sphere", "parameters": {"centre": [0.0, 0.0], "radius": 1.0}
    },
    "obstacles: 'below' is the name of a surface or region too": {"name": "below"},
    "contacts.0: surface 'floor' is not defined, known are below, ground": {"name": "ground"},
}  # fmt: skip


@pytest.mark.parametrize("sentence", REFUSED)
def test_what_makes_no_obstacle_is_refused(sentence: str) -> None:
    floor = {"name": "floor", "shape": "plane", "parameters": {}, **REFUSED[sentence]}
    with pytest.raises(RobotFileError, match=re.escape(sentence)):
        block(obstacles=[floor])


def test_what_a_basis_is_made_for_depends_on_the_obstacle() -> None:
    def digest(name: str, height: float) -> str:
        parameters = {"point": [0.0, 0.0, height], "normal": [0.0, 0.0, 1.0]}
        return block(
            obstacles=[{"name": name, "shape": "plane", "parameters": parameters}],
            contacts=[{"candidates": "below", "against": name}],
        ).digest

    assert digest("floor", 0.0) == digest("ground", 0.0)
    assert digest("floor", 0.0) != digest("floor", -1e-3)


@pytest.mark.parametrize("name", list(KNOWN))
def test_what_is_drawn_of_a_shape_lies_on_it(name: str) -> None:
    parameters, *_ = KNOWN[name]
    shape = SHAPES[name](**parameters)
    assert isinstance(shape, DrawnShape)
    centre = np.array([3.0, -1.0, 2.0])
    vertices, triangles = shape.outline(centre, 8.0)
    gap, _ = shape.closest(vertices)
    assert np.abs(gap).max() < 1e-12
    assert sorted(set(triangles.ravel().tolist())) == list(range(len(vertices)))
    middle = vertices[triangles].mean(axis=1)
    assert np.abs(shape.closest(middle)[0]).max() < 0.05, "and so do its triangles, nearly"
    if name == "plane":
        away = float(((vertices.mean(axis=0) - centre) ** 2).sum() ** 0.5)
        assert away == pytest.approx(shape.closest(centre[None])[0][0]), "around the robot"
    else:
        assert enclosed(vertices, triangles) == pytest.approx(VOLUMES[name], rel=0.05)


VOLUMES = {
    "sphere": 4.0 / 3.0 * np.pi * 8.0,
    "capsule": np.pi * 0.25 * (4.0 + 4.0 / 3.0 * 0.5),
    "cylinder": 16.0 * np.pi,
    "box": 16.0,
}


def enclosed(vertices: Array, triangles: Array) -> float:
    """Volume inside triangles whose normals all point outwards, or all inwards."""
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    return float(abs(np.einsum("ti,ti->t", a, np.cross(b, c)).sum()) / 6.0)
