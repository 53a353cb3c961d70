"""Boxes on boxes: they stand, or fall where their centre is beyond the edge; set-up says what would slip."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from support.robots.blocks import box, free_bodies, plane, touching

from tauten.model import Simulator
from tauten.model.mesh import TetMesh, boundary_triangles, covering_points, largest_hole
from tauten.model.schema import RobotFileError

EDGE, LENGTH, WIDTH, SPACING = 0.02, 0.08, 0.01, 0.0025
FLOOR = plane("floor", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0))


def stacked(low: TetMesh, up: TetMesh, points: dict[str, Any], friction: float) -> Simulator:
    """One body on another one, which stands on a floor."""
    contacts = [
        touching("low", "floor", friction=friction),
        touching("up", "low", friction=friction, **points),
        touching("low", "up", friction=friction, **points),
    ]
    gravity = [0.0, 0.0, -9.81]
    bodies = {"low": low, "up": up}
    return Simulator(free_bodies(bodies, contacts, 100.0, obstacles=[FLOOR], gravity=gravity))


def bars(turn: float) -> tuple[TetMesh, TetMesh]:
    """Two bars across each other, each turned about its axis [rad], the lower one standing on the floor."""
    c, s = np.cos(turn), np.sin(turn)
    low = box((LENGTH, WIDTH, WIDTH), (-0.5 * LENGTH, -0.5 * WIDTH, -0.5 * WIDTH), cells=1)
    up = box((WIDTH, LENGTH, WIDTH), (-0.5 * WIDTH, -0.5 * LENGTH, -0.5 * WIDTH), cells=1)
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
    about_y = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    half = 0.5 * WIDTH * (c + s)
    return (
        TetMesh(low.nodes @ about_x.T + [0.0, 0.0, half], low.tets),
        TetMesh(up.nodes @ about_y.T + [0.0, 0.0, 3.0 * half], up.tets),
    )


@pytest.mark.parametrize("friction", [0.0, 0.5])
@pytest.mark.parametrize("off", [0.0, 0.4, 0.6])  # of the edge
def test_a_box_stands_on_one_of_its_size_until_its_centre_is_beyond_the_edge(
    off: float, friction: float
) -> None:
    """All of its vertices are on the edges of the other one, or beyond them."""
    cube = (EDGE, EDGE, EDGE)
    low, up = box(cube, (0.0, 0.0, 0.0), cells=1), box(cube, (off * EDGE, 0.0, EDGE), cells=1)
    simulator = stacked(low, up, {"spacing": SPACING}, friction)
    for _ in range(25):
        assert simulator.move(effort=[0.0]).converged
    if off < 0.5:
        np.testing.assert_allclose(simulator.effector[:, 2], [0.5 * EDGE, 1.5 * EDGE], atol=1e-6)
        np.testing.assert_allclose(simulator.effector[1, 0], (off + 0.5) * EDGE, atol=1e-6)
    else:
        assert simulator.effector[1, 2] < EDGE


def test_a_bar_lies_across_another_one() -> None:
    simulator = stacked(*bars(0.0), {"spacing": SPACING}, 0.5)
    for _ in range(40):
        assert simulator.move(effort=[0.0]).converged
    np.testing.assert_allclose(simulator.effector[:, 2], [0.5 * WIDTH, 1.5 * WIDTH], atol=1e-6)


def test_what_would_fall_between_candidates_is_said_at_set_up(
    caplog: pytest.LogCaptureFixture,
) -> None:
    """A bar across another one has no vertex on it, a box on one of its size only vertices on edges."""
    stacked(*bars(0.0), {}, 0.5)
    (note,) = [record.getMessage() for record in caplog.records]
    assert "is 10 mm wide" in note
    assert "give spacing = 0.0025" in note
    caplog.clear()
    cube = (EDGE, EDGE, EDGE)
    low, up = box(cube, (0.0, 0.0, 0.0), cells=1), box(cube, (0.0, 0.0, EDGE), cells=1)
    stacked(low, up, {}, 0.5)
    (note,) = [record.getMessage() for record in caplog.records]
    assert "is 20 mm wide" in note
    caplog.clear()
    stacked(*bars(0.0), {"spacing": SPACING}, 0.5)
    stacked(low, up, {"spacing": 0.005}, 0.5)
    assert not caplog.records


@pytest.mark.parametrize("spacing", [None, SPACING])
def test_a_bar_lies_across_an_obstacle_or_set_up_says_that_it_falls(
    spacing: float | None, caplog: pytest.LogCaptureFixture
) -> None:
    ridge = {
        "lower": [-0.5 * LENGTH, -0.5 * WIDTH, 0.0],
        "upper": [0.5 * LENGTH, 0.5 * WIDTH, WIDTH],
    }
    obstacle = {"name": "ridge", "shape": "box", "parameters": ridge}
    bar = box((WIDTH, LENGTH, WIDTH), (-0.5 * WIDTH, -0.5 * LENGTH, WIDTH), cells=1)
    points = {} if spacing is None else {"spacing": spacing}
    contact, gravity = touching("bar", "ridge", friction=0.5, **points), [0.0, 0.0, -9.81]
    robot = free_bodies({"bar": bar}, [contact], 100.0, obstacles=[obstacle], gravity=gravity)
    assert len(caplog.records) == (spacing is None)
    simulator = Simulator(robot)
    for _ in range(10):
        simulator.move(effort=[0.0])
    falls = simulator.effector[0, 2] < 1.4 * WIDTH
    assert falls == (spacing is None)


def test_covering_points_are_at_vertices_along_edges_and_leave_small_holes() -> None:
    mesh = box((LENGTH, WIDTH, WIDTH), (0.0, 0.0, 0.0), cells=1)
    triangles = boundary_triangles(mesh.tets)
    nodes, weights = covering_points(mesh.nodes, triangles, SPACING)
    points = np.einsum("mj,mji->mi", weights, mesh.nodes[nodes])
    np.testing.assert_allclose(weights.sum(axis=1), 1.0, rtol=1e-12)
    for corner in mesh.nodes:
        assert np.linalg.norm(points - corner, axis=1).min() < 1e-12
    long_edge = points[np.linalg.norm(points[:, 1:], axis=1) < 1e-12, 0]
    assert np.diff(np.sort(long_edge)).max() < SPACING * (1.0 + 1e-9)
    assert largest_hole(mesh.nodes, triangles, points) < SPACING


def test_a_spacing_that_makes_too_many_candidates_is_refused() -> None:
    """Before anything of that size is computed: it took all memory of a computer."""
    with pytest.raises(RobotFileError, match=r"spacing = 1e-06 m would make .* make it larger"):
        stacked(*bars(0.0), {"spacing": 1e-6}, 0.5)
