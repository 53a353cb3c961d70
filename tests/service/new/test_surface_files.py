"""Files of surfaces and volumes that something is wrong with: a part, or one sentence that names the file."""

from __future__ import annotations

import warnings
from pathlib import Path

import meshio
import numpy as np
import pytest
from support.robots.bodies import box_mesh

from tauten.model import MeshError, load_robot
from tauten.model.mesh import boundary_triangles, read_mesh, uncancelled_triangles
from tauten.service.new import NewRobot, PartError, make_new_robot, read_part
from tauten.service.process import StopFlag

SIZE = (12.0, 12.0, 60.0)  # mm


def surface() -> tuple[np.ndarray, np.ndarray]:
    """Vertices [mm] and triangles of a box."""
    mesh = box_mesh(SIZE, (2, 2, 6))
    triangles = boundary_triangles(mesh.tets)
    used, numbers = np.unique(triangles, return_inverse=True)
    return mesh.nodes[used], numbers.reshape(-1, 3)


def obj_text(vertices: np.ndarray, triangles: np.ndarray) -> str:
    """The text of an OBJ file."""
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in vertices.tolist()]
    return "\n".join(lines + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles.tolist()])


@pytest.mark.parametrize("place", [0.0, 1.0, 1e9])
def test_triangles_whose_corners_coincide_are_refused(tmp_path: Path, place: float) -> None:
    path = tmp_path / "point.obj"
    path.write_text(obj_text(np.full((9, 3), place), np.arange(9).reshape(-1, 3)))
    with pytest.raises(
        PartError, match=r"point.obj: each of its 3 triangles has two corners at the"
    ):
        read_part(path, "mm", False)


@pytest.mark.parametrize("wrong", ["f 1 2 9", "f 0 1 2", "f -1 -2 -4"])
def test_corners_that_are_no_vertices_are_refused(tmp_path: Path, wrong: str) -> None:
    path = tmp_path / "beyond.obj"
    path.write_text(obj_text(np.eye(3), np.array([[0, 1, 2]])) + f"\n{wrong}\n")
    with pytest.raises(MeshError, match=r"beyond.obj: 1 of 2 triangles have corners that are none"):
        read_part(path, "mm", False)


def damaged(
    vertices: np.ndarray, triangles: np.ndarray, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """One to three vertices moved, joined or made huge, triangles lost, turned, given other corners."""
    points, corners = vertices.copy(), triangles.copy()
    for _ in range(rng.integers(1, 4)):
        point, triangle = rng.integers(len(points)), rng.integers(len(corners))
        action = rng.integers(6)
        if action == 0:
            points[point] = points[rng.integers(len(points))]
        elif action == 1:
            points[point, rng.integers(3)] = rng.choice([1e30, -1e30, 1e-300, np.nan, np.inf])
        elif action == 2:
            corners = np.delete(corners, triangle, axis=0)
        elif action == 3:
            corners[triangle] = corners[triangle][::-1]
        elif action == 4:
            corners[triangle, 0] = point
        else:
            points *= 10.0 ** rng.integers(-200, 30)
    return points, corners


def write_damaged(path: Path, rng: np.random.Generator, binary: bool) -> None:
    """A damaged surface, in each fifth file with bytes replaced and the end lost too."""
    points, corners = damaged(*surface(), rng)
    if path.suffix == ".obj":
        path.write_text(obj_text(points, corners))
    else:
        with warnings.catch_warnings(action="ignore"), np.errstate(all="ignore"):
            meshio.write(path, meshio.Mesh(points, [("triangle", corners)]), binary=binary)
    if rng.random() < 0.2:
        contents = bytearray(path.read_bytes())
        for place in rng.integers(len(contents), size=3):
            contents[place] = rng.integers(256)
        path.write_bytes(bytes(contents[: rng.integers(1, len(contents))]))


@pytest.mark.parametrize("kind", ["stl", "obj", "ply"])
def test_damaged_surfaces_give_a_part_or_a_sentence(tmp_path: Path, kind: str) -> None:
    refused = 0
    for case in range(60):
        path = tmp_path / f"case{case}.{kind}"
        write_damaged(path, np.random.default_rng([7, ord(kind[0]), case]), bool(case % 2))
        try:
            part = read_part(path, "mm", False)
        except (PartError, MeshError) as error:
            assert str(error).startswith(str(path)), error
            assert "\n" not in str(error)
            refused += 1
        else:
            assert part.volume > 0.0
    assert refused > 20


def test_a_header_without_end_does_not_keep_the_reader(tmp_path: Path) -> None:
    path = tmp_path / "cut.ply"
    path.write_bytes(b"ply\nformat ascii 1.0\nelement vertex 8\nproperty double x\n")
    with pytest.raises(
        MeshError, match=r"cut.ply: not readable as a mesh .it is cut off, .*'end_header'"
    ):
        read_part(path, "mm", False)


def overlapping(path: Path) -> Path:
    """A box of tetrahedra, and on one of its sides some that lie within it too."""
    mesh = box_mesh(SIZE, (2, 2, 6))
    centre = np.array([[6.0, 6.0, 30.0]])
    outer = boundary_triangles(mesh.tets)[:4, ::-1]
    more = np.concatenate([outer, np.full((4, 1), len(mesh.nodes))], axis=1)
    nodes, tets = np.vstack([mesh.nodes, centre]), np.vstack([mesh.tets, more])
    meshio.Mesh(nodes, [("tetra", tets)]).write(path)
    return path


def test_overlapping_tetrahedra_are_counted_and_their_outside_is_taken(tmp_path: Path) -> None:
    pytest.importorskip("wildmeshing", reason="tauten[repair] is not installed")
    path = overlapping(tmp_path / "double.vtu")
    with pytest.raises(MeshError, match=r"double.vtu: 4 pairs of .* as `tauten new --repair` does"):
        read_mesh(path, "mm")
    part = read_part(path, "mm", repair=True)
    assert part.surface is not None
    tets = box_mesh(SIZE, (2, 2, 6)).tets
    outside = {tuple(sorted(face)) for face in boundary_triangles(tets).tolist()}
    found = {tuple(sorted(face)) for face in part.surface.triangles.tolist()}
    assert outside <= found  # and, within, the faces of the tetrahedra that lie in others
    assert np.prod(SIZE) * 1e-9 < part.volume < 1.2 * np.prod(SIZE) * 1e-9


def test_without_overlaps_the_outside_is_the_boundary() -> None:
    tets = box_mesh(SIZE, (2, 2, 6)).tets
    assert np.array_equal(uncancelled_triangles(tets), boundary_triangles(tets))


@pytest.mark.slow
def test_overlapping_tetrahedra_are_meshed_anew(tmp_path: Path) -> None:
    pytest.importorskip("wildmeshing", reason="tauten[repair] is not installed")
    part = read_part(overlapping(tmp_path / "double.vtu"), "mm", repair=True)
    new = NewRobot("again", part, size=8e-3)
    made = make_new_robot(new, tmp_path / "again", StopFlag(), lambda share, what: None)
    volume = load_robot(made.file).body.mesh.volumes.sum()
    assert volume == pytest.approx(np.prod(SIZE) * 1e-9, rel=0.02)


@pytest.mark.parametrize("name", ["a b", "1st", 'x"\ny = 1', "\udcff", "ü", "", "name\n"])
def test_names_that_no_robot_can_have_are_refused_first(tmp_path: Path, name: str) -> None:
    mesh = box_mesh(tuple(1e-3 * side for side in SIZE), (1, 1, 4))
    meshio.Mesh(mesh.nodes, [("tetra", mesh.tets)]).write(tmp_path / "bar.vtu")
    new = NewRobot(name, read_part(tmp_path / "bar.vtu", "m", False))
    with pytest.raises(
        PartError, match="allowed are a letter, then letters, digits and _"
    ) as error:
        make_new_robot(new, tmp_path / "made", StopFlag(), lambda share, what: None)
    assert str(error.value).isprintable()


@pytest.mark.long
def test_the_name_of_the_parts_file_stays_within_its_comment(tmp_path: Path) -> None:
    """A line feed would end the comment; a lone surrogate cannot be encoded."""
    mesh = box_mesh(tuple(1e-3 * side for side in SIZE), (2, 2, 6))
    path = tmp_path / "bar\ngravity = [9.0, 0.0, 0.0] #\udcff.vtu"
    meshio.Mesh(mesh.nodes, [("tetra", mesh.tets)]).write(tmp_path / "bar.vtu")
    (tmp_path / "bar.vtu").rename(path)
    new = NewRobot("bar", read_part(path, "m", False))
    made = make_new_robot(new, tmp_path / "bar", StopFlag(), lambda share, what: None)
    first = made.file.read_text().splitlines()[0]
    assert "from bar?gravity = [9.0, 0.0, 0.0] #?.vtu" in first
    assert load_robot(made.file).gravity[0] == 0.0
