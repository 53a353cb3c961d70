"""Obstacles of triangles: signed distances against known ones and all triangles, and what is refused."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest

from tauten.model import RobotFileError
from tauten.model.actuators import winding
from tauten.model.contact import Shape, heights_of_file, mesh_of_file
from tauten.model.contact.mesh_shape import MeshShape
from tauten.model.contact.outlines import box, cylinder, rod
from tauten.model.contact.shapes import BoxShape
from tauten.model.load.extensions import made
from tauten.model.mesh import welded
from tauten.model.mesh.triangle_distance import distances_to_triangles
from tauten.model.numerics import Array, Ints

rng = np.random.default_rng(0)


def torus(radius: float, tube: float, around: int, across: int) -> tuple[Array, Ints]:
    """A ring about the z axis: vertices (v, 3) [m] and 2 · around · across triangles (t, 3).

    Args:
        radius: of its centre line [m].
        tube: of the tube [m].
        around: pieces around the axis.
        across: pieces around the tube.
    """
    i, j = np.indices((around, across))
    u, v = 2.0 * np.pi * i / around, 2.0 * np.pi * j / across
    away = radius + tube * np.cos(v)
    vertices = np.stack([away * np.cos(u), away * np.sin(u), tube * np.sin(v)], axis=2)

    def number(one: Ints, other: Ints) -> Ints:
        found: Ints = ((one % around) * across + other % across).ravel()
        return found

    a, b, c, d = number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return vertices.reshape(-1, 3), triangles


def by_all_triangles(points: Array, vertices: Array, triangles: Ints) -> Array:
    """Signed distances (m,): the least one to any triangle, and the winding number."""
    distance = distances_to_triangles(points, vertices[triangles])
    inside = [abs(winding(vertices, triangles, point)) > 0.5 for point in points]
    return np.where(inside, -distance, distance)


def test_a_box_of_triangles_is_a_box() -> None:
    lower, upper = np.array([-1.0, -1.0, -1.0]), np.array([3.0, 1.0, 1.0])
    vertices, triangles = box(lower, upper)
    mesh, known = MeshShape(vertices, triangles), BoxShape(lower, upper)
    points = rng.uniform(-3.0, 4.0, (2000, 3))
    gap, normal = mesh.closest(points)
    expected, direction = known.closest(points)
    np.testing.assert_allclose(gap, expected, atol=1e-12)
    np.testing.assert_allclose(normal, direction, atol=1e-9)


def test_on_the_surface_the_normal_is_that_of_the_feature() -> None:
    vertices, triangles = box(np.zeros(3), np.ones(3))
    on = np.array([[0.3, 0.6, 1.0], [1.0, 0.5, 1.0], [1.0, 1.0, 1.0]])  # face, edge, corner
    gap, normal = MeshShape(vertices, triangles).closest(on)
    np.testing.assert_allclose(gap, 0.0, atol=1e-12)
    expected = np.array([[0.0, 0.0, 1.0], [0.5**0.5, 0.0, 0.5**0.5], [3**-0.5] * 3])
    np.testing.assert_allclose(normal, expected, atol=1e-12)


SURFACES = {
    "cylinder": cylinder(np.array([0.1, 0.0, 0.2]), np.array([0.0, 0.3, 0.4]), 0.2),
    "rod": welded((lambda found: found[0][found[1]])(rod(np.zeros(3), np.array([1.0, 0, 0]), 0.3))),
    "torus": torus(0.5, 0.2, 40, 20),
}


@pytest.mark.long
@pytest.mark.parametrize("name", SURFACES)
def test_distances_are_those_to_all_triangles(name: str) -> None:
    vertices, triangles = SURFACES[name]
    shape = MeshShape(vertices, triangles)
    points = rng.uniform(-1.0, 1.0, (400, 3))
    expected = by_all_triangles(points, vertices, triangles)
    gap, normal = shape.closest(points)
    np.testing.assert_allclose(gap, expected, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1.0)
    feet = points - gap[:, None] * normal
    np.testing.assert_allclose(distances_to_triangles(feet, vertices[triangles]), 0.0, atol=1e-12)
    near, direction = shape.closest_within(points, 0.3)
    wanted = expected < 0.3
    assert 20 < wanted.sum() < 380
    np.testing.assert_array_equal(near[wanted], gap[wanted])
    np.testing.assert_array_equal(direction[wanted], normal[wanted])
    assert (near[~wanted] >= 0.3).all()


def test_far_points_are_no_whole_numbers() -> None:
    """The cell of a point a thousand kilometres away is that of the border of the grid."""
    vertices, triangles = box(np.zeros(3), np.ones(3))
    gap, normal = MeshShape(vertices, triangles).closest(
        np.array([[1e6, 0.5, 0.5], [0.5, -1e30, 0.5]])
    )
    np.testing.assert_allclose(gap, [1e6 - 1.0, 1e30])
    np.testing.assert_allclose(normal, [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0]], atol=1e-6)


def write(path: Path, vertices: Array, triangles: Ints) -> Path:
    meshio.write(path, meshio.Mesh(vertices, [("triangle", triangles)]))
    return path


def test_an_stl_file_in_millimetres(tmp_path: Path) -> None:
    """STL repeats corners in single precision; they are joined."""
    vertices, triangles = box(np.zeros(3), np.array([20.0, 30.0, 40.0]))
    write(tmp_path / "part.stl", vertices, triangles)
    shape = mesh_of_file(tmp_path, "part.stl", "mm")
    gap, _ = shape.closest(np.array([[0.01, 0.01, 0.05], [0.01, 0.01, 0.035], [0.06, 0.03, 0.01]]))
    np.testing.assert_allclose(gap, [0.01, -0.005, 0.04], atol=1e-9)
    assert len(shape.outline(np.zeros(3), 1.0)[0]) == 8


def test_what_is_no_closed_surface_is_refused(tmp_path: Path) -> None:
    vertices, triangles = box(np.zeros(3), np.ones(3))
    for name, faces, sentence in (
        ("open", triangles[1:], "is not closed: 3 edges, the first at"),
        ("inverted", triangles[:, ::-1], "is inside out: it encloses -1 m³; turn its triangles"),
        ("half", np.vstack([triangles[:1, ::-1], triangles[1:]]), "is not closed: 3 edges"),
    ):
        write(tmp_path / f"{name}.stl", vertices, faces)
        with pytest.raises(ValueError, match=re.escape(sentence)):
            mesh_of_file(tmp_path, f"{name}.stl")
    (tmp_path / "text.stl").write_text("no mesh")
    for file, sentence in (
        ("text.stl", "not readable as a mesh"), ("other.stl", "no such file"), (3.0, "expected the name"),
    ):  # fmt: skip
        with pytest.raises(ValueError, match=sentence):
            mesh_of_file(tmp_path, file)  # type: ignore[arg-type]
    write(tmp_path / "closed.stl", vertices, triangles)
    with pytest.raises(ValueError, match="allowed are 'm', 'cm', 'mm'"):
        mesh_of_file(tmp_path, "closed.stl", "inch")


def test_a_slope_of_heights_is_a_plane() -> None:
    """z = 0.2 + 0.5 x above a corner at (1, 2, 3): near its middle the distance is that to a plane."""
    heights = np.repeat(0.2 + 0.5 * 0.1 * np.arange(11)[:, None], 21, axis=1)
    shape = heights_of_file(Path(), np.array([1.0, 2.0, 3.0]), np.array([0.1, 0.05]), 0.5, heights)
    points = np.array([1.5, 2.5, 3.45]) + rng.uniform(-0.1, 0.1, (100, 3))
    gap, normal = shape.closest(points)
    up = np.array([-0.5, 0.0, 1.0]) / 1.25**0.5
    np.testing.assert_allclose(gap, (points - [1.0, 2.0, 3.2]) @ up, atol=1e-12)
    np.testing.assert_allclose(normal, np.tile(up, (100, 1)), atol=1e-9)


def test_heights_of_a_file_are_a_closed_body(tmp_path: Path) -> None:
    table = rng.uniform(0.0, 0.02, (5, 4))
    np.savetxt(tmp_path / "ground.csv", table, delimiter=",")
    shape = heights_of_file(tmp_path, np.zeros(3), np.array([0.01, 0.02]), 0.01, file="ground.csv")
    vertices, triangles = shape.outline(np.zeros(3), 1.0)
    np.testing.assert_allclose(vertices[:20, 2].reshape(5, 4), table)
    np.testing.assert_allclose(vertices[20:, 2], table.min() - 0.01)
    points = rng.uniform([-0.01, -0.01, -0.02], [0.05, 0.07, 0.03], (200, 3))
    expected = by_all_triangles(points, vertices, triangles)
    np.testing.assert_allclose(shape.closest(points)[0], expected, atol=1e-12)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"heights": [[0.0, 1.0]]}, "at least two by two finite numbers, found one of 1 by 2"),
        ({"heights": [[0.0, 1.0], [np.nan, 0.0]]}, "numbers that are not finite"),
        ({"heights": None}, "give them as a table, or the name of a file"),
        ({"file": "other.csv"}, "and not both"),
        ({"heights": None, "file": "other.csv"}, "no such file"),
        ({"heights": None, "file": "ragged.csv"}, "different numbers of heights"),
        ({"heights": None, "file": "text.csv"}, "is no table of numbers"),
        ({"spacing": [1.0, 0.0]}, "spacing: found 0.0, expected a positive number"),
        ({"spacing": [1.0]}, "spacing: expected two numbers"),
        ({"thickness": -1.0}, "thickness: found -1.0, expected a positive number"),
        ({"thickness": "thin"}, "thickness: found thin, expected a positive number"),
        ({"heights": None, "file": "empty.csv"}, "has no heights"),
    ],
)
def test_heights_that_make_no_body_are_refused(
    tmp_path: Path, changes: dict[str, Any], sentence: str
) -> None:
    (tmp_path / "ragged.csv").write_text("1 2\n3\n")
    (tmp_path / "text.csv").write_text("high, low\n")
    (tmp_path / "empty.csv").write_text("\n")
    table: dict[str, Any] = {
        "corner": np.zeros(3), "spacing": [1.0, 1.0], "thickness": 1.0, "heights": np.eye(3), **changes,
    }  # fmt: skip
    with pytest.raises(ValueError, match=sentence):
        heights_of_file(tmp_path, **table)


def test_rows_of_different_lengths_in_a_robot_file_are_refused() -> None:
    field = {"heights": [[0.0, 0.0], [0.0]], "corner": [0.0, 0.0, 0.0], "spacing": [1.0, 1.0]}
    with pytest.raises(RobotFileError, match="heights: rows of different lengths make no table"):
        made(heights_of_file, Shape, "obstacles.0", {**field, "thickness": 1.0}, Path())
