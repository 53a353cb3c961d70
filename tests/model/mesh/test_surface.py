"""Boundaries enclose what they bound; spread points cover a surface evenly."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from tauten.model import Robot
from tauten.model.mesh import (
    area_normals,
    boundary_triangles,
    spread_points,
    triangle_areas,
    unit_normals,
)
from tauten.model.numerics import Array, Ints
from tauten.model.tetra import NodalBody


def rectangle(width: float, height: float) -> tuple[Array, Ints]:
    """Two triangles of very different size and shape beside each other, and one flat one."""
    x = np.array(
        [[0, 0, 0], [width, 0, 0], [width, height, 0], [0, height, 0], [0, 0.1 * height, 0]]
    )
    return x, np.array([[0, 1, 4], [4, 1, 2], [4, 2, 3], [0, 4, 3]])


def test_boundary_of_the_finger_encloses_its_volume(finger: Robot[NodalBody]) -> None:
    """Gauss: ∮ x·n dA = 3 V, which fails when a triangle is missing or turned over."""
    mesh = finger.body.mesh
    corners = mesh.nodes[boundary_triangles(mesh.tets)]  # (t, 3, 3)
    area = 0.5 * area_normals(corners)
    np.testing.assert_allclose(area.sum(axis=0), 0.0, atol=1e-15)
    volume = np.einsum("ti,ti->", corners.mean(axis=1), area) / 3.0
    assert volume == pytest.approx(mesh.volumes.sum(), rel=1e-12)


def test_normals_are_of_length_one_and_those_of_flat_triangles_zero() -> None:
    x, triangles = rectangle(2e-3, 1e-3)
    expected = np.array([[0, 0, 1], [0, 0, 1], [0, 0, 1], [0, 0, 0]], dtype=float)
    np.testing.assert_array_equal(unit_normals(x[triangles]), expected)


def test_boundary_edges_are_shared_by_two(finger: Robot[NodalBody]) -> None:
    triangles = boundary_triangles(finger.body.mesh.tets)
    edges = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    assert len(np.unique(edges, axis=0)) == len(edges)  # each sense once
    assert {tuple(edge) for edge in edges} == {tuple(edge) for edge in edges[:, ::-1]}


def test_single_tetrahedron() -> None:
    assert boundary_triangles(np.array([[0, 1, 2, 3]])).tolist() == [
        [1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1],
    ]  # fmt: skip


@settings(max_examples=25, deadline=None)
@given(st.integers(1, 150), st.floats(0.3, 3.0))
def test_points_are_inside_and_cover_evenly(count: int, ratio: float) -> None:
    x, triangles = rectangle(0.01, 0.01 * ratio)
    nodes, weights = spread_points(x, triangles, count)
    assert nodes.shape == weights.shape == (count, 3)
    assert weights.min() > 0.0
    np.testing.assert_allclose(weights.sum(axis=1), 1.0, atol=1e-12)
    rows = {tuple(triangle) for triangle in triangles.tolist()}
    assert all(tuple(row) in rows for row in nodes.tolist())
    points = np.einsum("ci,cij->cj", weights, x[nodes])
    spacing = np.sqrt(triangle_areas(x, triangles).sum() / count)
    grid = np.stack(np.meshgrid(np.linspace(0, 0.01, 41), np.linspace(0, 0.01 * ratio, 41)), -1)
    grid = np.concatenate([grid.reshape(-1, 2), np.zeros((41 * 41, 1))], axis=1)
    farthest = cKDTree(points).query(grid)[0].max()
    assert farthest < 1.25 * spacing or count < 8  # corners and borders included
    if count >= 8:
        assert cKDTree(points).query(points, k=2)[0][:, 1].min() > 0.4 * spacing
        border = np.minimum(points[:, :2], [0.01, 0.01 * ratio] - points[:, :2]).min(axis=1)
        assert border.min() > 0.15 * spacing  # a small slip keeps them over a facing surface


def test_area_per_point_is_even() -> None:
    x, triangles = rectangle(0.01, 0.015)
    nodes, weights = spread_points(x, triangles, 99)
    points = np.einsum("ci,cij->cj", weights, x[nodes])
    samples = np.random.default_rng(0).uniform(0.0, 1.0, (200_000, 2)) * [0.01, 0.015]
    _, cell = cKDTree(points[:, :2]).query(samples)
    share = np.bincount(cell, minlength=99) / len(samples) * 99
    assert 0.5 < share.min() < share.max() < 1.6


def test_same_surface_same_points(finger: Robot[NodalBody]) -> None:
    triangles = finger.contacts.pairs[0].triangles
    first, again = (spread_points(finger.body.mesh.nodes, triangles, 99) for _ in range(2))
    np.testing.assert_array_equal(first[0], again[0])
    np.testing.assert_array_equal(first[1], again[1])


@pytest.mark.parametrize("count", [12, 45, 99])
def test_rounding_does_not_move_points(count: int) -> None:
    """A square grid is full of ties; another compiler, library or processor rounds otherwise."""
    i, j = (part.ravel() for part in np.meshgrid(np.arange(6), np.arange(6), indexing="ij"))
    corner = (7 * i + j)[:, None]
    triangles = np.concatenate([corner + np.array([0, 7, 8]), corner + np.array([0, 8, 1])])
    grid = np.stack(np.meshgrid(np.arange(7.0), np.arange(7.0), indexing="ij"), axis=-1)
    x = 1e-3 * np.concatenate([grid.reshape(-1, 2), np.zeros((49, 1))], axis=1)
    nodes, weights = spread_points(x, triangles, count)
    rng = np.random.default_rng(0)
    for _ in range(5):
        rounded = x * (1.0 + 1e-15 * rng.uniform(-1.0, 1.0, x.shape))
        again = spread_points(rounded, triangles, count)
        np.testing.assert_array_equal(again[0], nodes)
        np.testing.assert_array_equal(again[1], weights)


def test_no_points_or_no_area_are_refused() -> None:
    x, triangles = rectangle(0.01, 0.01)
    with pytest.raises(ValueError, match="count is 0, at least one point is needed"):
        spread_points(x, triangles, 0)
    with pytest.raises(ValueError, match="the surface of 1 triangles has no area"):
        spread_points(np.zeros((3, 3)), np.array([[0, 1, 2]]), 5)
