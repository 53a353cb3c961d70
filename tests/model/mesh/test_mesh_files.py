"""Mesh files as other programs write them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest

from tauten.model.mesh import MeshError, read_mesh, read_triangles, triangle_areas

CORNERS = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
SIDES = [(1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4)]


@pytest.mark.parametrize("relative", [False, True])
def test_a_cube_as_blender_writes_it_has_the_area_of_a_cube(tmp_path: Path, relative: bool) -> None:
    """Quads, colours of vertices, and another number of points of the texture than of the surface."""
    lines = [f"v {x} {y} {z} 0.5 0.5 0.5" for x, y, z in CORNERS] + ["vt 0 0", "vt 1 1", "o cube"]
    for side in SIDES:
        numbers = [n - 9 if relative else n for n in side]
        lines.append("f " + " ".join(f"{n}/1/" for n in numbers))
    (tmp_path / "cube.obj").write_text("\n".join(lines))
    vertices, triangles = read_triangles(tmp_path / "cube.obj")
    assert len(triangles) == 12
    np.testing.assert_allclose(triangle_areas(vertices, triangles), 0.5)


def test_faces_with_five_corners_are_divided(tmp_path: Path) -> None:
    turns = 2.0 * np.pi * np.arange(5) / 5
    points = np.stack([np.cos(turns), np.sin(turns), 0.0 * turns], axis=1)
    lines = [f"v {x} {y} {z}" for x, y, z in points] + ["f 1 2 3 4 5"]
    (tmp_path / "five.obj").write_text("\n".join(lines))
    area = triangle_areas(*read_triangles(tmp_path / "five.obj")).sum()
    assert area == pytest.approx(2.5 * np.sin(2.0 * np.pi / 5))


def test_corners_that_are_no_vertices_are_refused(tmp_path: Path) -> None:
    (tmp_path / "bad.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n")
    with pytest.raises(MeshError, match="corners that are none of the 3 vertices"):
        read_triangles(tmp_path / "bad.obj")


def test_a_vtk_file_may_hold_xml(tmp_path: Path) -> None:
    """SOFA's diamond.vtk does."""
    nodes = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    mesh = meshio.Mesh(nodes, [("tetra", np.array([[0, 1, 2, 3]]))])
    mesh.write(tmp_path / "one.vtu")
    xml = (tmp_path / "one.vtu").read_text().split("?>")[-1]
    (tmp_path / "one.vtk").write_text(xml)
    np.testing.assert_array_equal(read_mesh(tmp_path / "one.vtk").nodes, nodes)


CUT = {  # file written: [keywords of meshio, share of the bytes that is left, what is said]
    "binary.stl": ({"binary": True}, 0.5, "the 12 triangles that its header counts need 684"),
    "text.stl": ({"binary": False}, 0.5, "it is cut off: 'endsolid' is missing"),
    "short.stl": ({"binary": True}, 0.1, "it has 68 bytes, the header of an STL file has 84"),
    "header.ply": ({"binary": False}, 0.2, "'end_header' is missing"),
    "text.ply": ({"binary": False}, 0.7, "it is cut off, damaged or of another format"),
    "surface.obj": ({}, 0.3, "it is cut off, damaged or of another format"),
    "grid.vtu": ({}, 0.6, "'</VTKFile>' is missing"),
    "gmsh.msh": ({"file_format": "gmsh"}, 0.9, "'\\$EndElements' is missing"),
    "old.msh": ({"file_format": "gmsh22", "binary": False}, 0.9, "'\\$EndElements' is missing"),
    "grid.vtk": ({"file_format": "vtk42"}, 0.99, "it is cut off: it has 4 of 5 cells"),
    "empty.vtu": ({}, 0.0, "it is empty"),
}


def write(path: Path, keywords: dict[str, Any]) -> None:
    """A cube: its surface, or five tetrahedra."""
    tets = [[0, 1, 2, 4], [3, 1, 7, 2], [5, 1, 4, 7], [6, 2, 7, 4], [1, 2, 4, 7]]
    quads = np.array(SIDES) - 1
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    volume = path.suffix in (".vtu", ".vtk", ".msh")
    cells = [("tetra", np.array(tets)) if volume else ("triangle", triangles.astype(np.int32))]
    meshio.Mesh(np.array(CORNERS, dtype=float), cells).write(path, **keywords)


@pytest.mark.parametrize("name", CUT)
def test_files_that_are_cut_off_say_so_and_what_to_do(tmp_path: Path, name: str) -> None:
    keywords, share, said = CUT[name]
    path = tmp_path / name
    read = read_mesh if path.suffix in (".vtu", ".vtk", ".msh") else read_triangles
    write(path, keywords)
    read(path)
    path.write_bytes(path.read_bytes()[: int(share * path.stat().st_size)])
    with pytest.raises(
        MeshError, match=rf"{name}: not readable as a mesh \(.*{said}.*\); export it again$"
    ):
        read(path)


def test_a_folder_and_other_suffixes_are_no_mesh_files(tmp_path: Path) -> None:
    (tmp_path / "part.step").write_text("ISO-10303-21;")
    with pytest.raises(
        MeshError, match=r"no mesh format has the suffix '.step'; .* `tauten new` takes"
    ):
        read_mesh(tmp_path / "part.step")
    with pytest.raises(MeshError, match="is a folder, expected a mesh file"):
        read_mesh(tmp_path)
