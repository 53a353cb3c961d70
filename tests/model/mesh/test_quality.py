"""Shape of elements, loose parts and thickness of walls, against what geometry says."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest
from support.robots.bodies import box_mesh

from tauten.model.mesh import (
    MeshError,
    TetMesh,
    boundary_triangles,
    mean_ratios,
    part_numbers,
    quadratic_mesh,
    read_unchecked_mesh,
    wall_thickness,
)

REGULAR = np.array([[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]])
CORNERS = np.array([[0, 1, 2, 3]])


@pytest.mark.parametrize("scale", [1e-3, 1.0, 50.0])
def test_a_regular_tetrahedron_has_the_mean_ratio_one(scale: float) -> None:
    mesh = TetMesh(scale * REGULAR, CORNERS)
    sign = np.sign(mesh.volumes[0])
    assert sign * mean_ratios(mesh)[0] == pytest.approx(1.0, rel=1e-12)
    swapped = TetMesh(scale * REGULAR, CORNERS[:, [0, 2, 1, 3]])
    assert sign * mean_ratios(swapped)[0] == pytest.approx(-1.0, rel=1e-12)


def test_a_flattened_tetrahedron_has_a_small_mean_ratio() -> None:
    ratios = []
    for height in (1.0, 0.1, 0.01, 0.0):
        nodes = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, height]])
        ratios.append(mean_ratios(TetMesh(nodes, CORNERS))[0])
    # a corner of a cube: V = 1/6, the squares of its edges sum to 9
    assert ratios[0] == pytest.approx(12.0 * 0.5 ** (2.0 / 3.0) / 9.0)
    assert ratios == sorted(ratios, reverse=True)
    assert ratios[-1] == 0.0


def test_parts_are_joined_by_faces_alone() -> None:
    one = box_mesh((1.0, 1.0, 1.0), (2, 1, 1))
    assert set(part_numbers(one.tets)) == {0}
    second = TetMesh(one.nodes + np.array([3.0, 0.0, 0.0]), one.tets)
    both = np.vstack([one.tets, second.tets + len(one.nodes)])
    assert np.bincount(part_numbers(both)).tolist() == [len(one.tets), len(one.tets)]


@pytest.mark.parametrize("thickness", [0.002, 0.01])
def test_the_thickness_of_a_plate_is_found_on_both_sides(thickness: float) -> None:
    mesh = box_mesh((0.05, 0.04, thickness), (5, 4, 2))
    boundary = boundary_triangles(mesh.tets)
    heights = mesh.nodes[boundary][:, :, 2]  # (t, 3)
    for level in (0.0, thickness):
        side = boundary[np.isclose(heights, level).all(axis=1)]
        assert len(side) == 40
        np.testing.assert_allclose(wall_thickness(mesh.nodes, boundary, side), thickness)


def test_a_file_is_read_as_it_is(tmp_path: Path) -> None:
    """With an inverted element, and quadratic elements by their corners."""
    mesh = box_mesh((1.0, 1.0, 1.0), (1, 1, 1))
    tets = mesh.tets.copy()
    tets[0] = tets[0][[0, 2, 1, 3]]
    meshio.write(tmp_path / "one.vtu", meshio.Mesh(mesh.nodes, [("tetra", tets)]))
    read = read_unchecked_mesh(tmp_path / "one.vtu", "mm")
    assert (mean_ratios(read) < 0.0).sum() == 1
    assert read.size == pytest.approx(1e-3 * mesh.size)
    quadratic = quadratic_mesh(mesh)
    order = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9]
    cells = [("tetra10", quadratic.tets[:, order])]
    meshio.write(tmp_path / "two.vtu", meshio.Mesh(quadratic.nodes, cells))
    corners = read_unchecked_mesh(tmp_path / "two.vtu")
    assert corners.tets.shape == mesh.tets.shape
    assert corners.volumes.sum() == pytest.approx(1.0)
    triangle = meshio.Mesh(mesh.nodes, [("triangle", np.array([[0, 1, 2]]))])
    meshio.write(tmp_path / "three.vtu", triangle)
    with pytest.raises(MeshError, match=r"three.vtu: no tetrahedra found"):
        read_unchecked_mesh(tmp_path / "three.vtu")
