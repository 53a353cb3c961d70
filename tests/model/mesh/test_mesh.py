"""Meshes: refinement, and a sentence for everything that cannot carry a robot."""

from __future__ import annotations

import io
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path

import meshio
import numpy as np
import pytest
from scipy.optimize import nnls
from support.robots.bodies import box_mesh

from tauten.model.mesh import MeshError, checked, read_mesh, require_size
from tauten.model.numerics import Array
from tauten.model.points import attach

TETS = np.array([[0, 1, 2, 3]])
NODES = 0.05 * np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])


def write(path: Path, nodes: np.ndarray, tets: np.ndarray, kind: str = "tetra") -> Path:
    meshio.write(path, meshio.Mesh(nodes, [(kind, tets)]))
    return path


@pytest.mark.parametrize("suffix", [".vtu", ".vtk", ".msh"])
def test_formats_and_units(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"one{suffix}"
    meshio.write(
        path,
        meshio.Mesh(1e3 * NODES, [("tetra", TETS)]),
        **({"file_format": "gmsh22"} if suffix == ".msh" else {}),
    )
    mesh = read_mesh(path, "mm")
    assert np.allclose(mesh.nodes, NODES)
    assert mesh.volumes.sum() == pytest.approx(0.05**3 / 6)


def test_refinement_keeps_volume_and_shares_nodes() -> None:
    mesh = box_mesh((0.1, 0.1, 0.1), (2, 2, 2))
    fine = mesh.refine()
    assert len(fine.tets) == 8 * len(mesh.tets)
    assert fine.volumes.min() > 0.0
    assert fine.volumes.sum() == pytest.approx(mesh.volumes.sum())
    assert len(fine.nodes) == 5**3


def test_refinement_gives_the_sizes_of_the_peers_table(reference: Path) -> None:
    mesh = read_mesh(reference / "softrobots_finger.vtk", "mm")
    sizes = []
    for _ in range(3):
        sizes.append((len(mesh.nodes), len(mesh.tets)))
        mesh = mesh.refine()
    assert sizes == [(158, 389), (857, 3112), (5437, 24896)]


def test_a_wholly_mirrored_mesh_is_turned_around(tmp_path: Path) -> None:
    mesh = read_mesh(write(tmp_path / "m.vtu", NODES, TETS[:, [0, 2, 1, 3]]))
    assert mesh.volumes.min() > 0.0


def test_unused_nodes_are_dropped(tmp_path: Path) -> None:
    nodes = np.vstack([[[9.0, 9.0, 9.0]], NODES])
    assert len(read_mesh(write(tmp_path / "m.vtu", nodes, TETS + 1)).nodes) == 4


BAD = {
    "no tetrahedra found, only triangle": (NODES, np.array([[0, 1, 2]]), "triangle"),
    "1 inverted tetrahedra, the first is 1": (
        np.vstack([NODES, [[0.05, 0.05, 0.05]]]),
        np.array([[0, 1, 2, 3], [1, 2, 4, 3]]),
        "tetra",
    ),
    "1 flat tetrahedra, the first is 1": (
        np.vstack([NODES, [[0.025, 0.025, 0.0]]]),
        np.array([[0, 1, 2, 3], [0, 1, 2, 4]]),
        "tetra",
    ),
    "1 tetrahedra beside the largest body's 2: 1 around .0.0125, 0.0125, 0.0125. .m.; unite them in CAD": (
        np.vstack([NODES, NODES + 0.2, NODES[1:] * [1, 1, -1] + 0.2]),
        np.array([[4, 5, 6, 7], [0, 1, 2, 3], [4, 6, 5, 10]]),
        "tetra",
    ),
    "1 tetrahedra beside the largest body's 1: 1 around .-0.0125, -0.0125, -0.0125. .m.; some share": (
        np.vstack([NODES, NODES[1:] * -1.0]),
        np.array([[0, 1, 2, 3], [0, 4, 6, 5]]),
        "tetra",
    ),
    "1 around .0.0125, -0.0125, -0.0125. .m.; some share only a node or an edge with the rest": (
        np.vstack([NODES, NODES[2:] * -1.0]),
        np.array([[0, 1, 2, 3], [0, 1, 4, 5]]),
        "tetra",
    ),
    "1 tetrahedra are given more than once, for example 0": (
        NODES,
        np.array([[0, 1, 2, 3], [1, 2, 0, 3]]),
        "tetra",
    ),
    "1 pairs of tetrahedra, for example 0 and 1, lie on the same side .*, 2 of 2 tetrahedra .100 %.": (
        np.vstack([NODES, [[0.01, 0.01, 0.04]]]),
        np.array([[0, 1, 2, 3], [0, 1, 2, 4]]),
        "tetra",
    ),
    "tetrahedron 1 has the corners .0, 1, 2, 9., the nodes are 0 to 3": (
        NODES,
        np.array([[0, 1, 2, 3], [0, 1, 2, 9]]),
        "tetra",
    ),
    "tetrahedron 1 has the corners .0, 1, 2, -1., the nodes are 0 to 4": (
        np.vstack([NODES, [[0.0, 0.0, -0.05]]]),
        np.array([[0, 1, 2, 3], [0, 1, 2, -1]]),
        "tetra",
    ),
    "the mesh is inf m long": (np.where(NODES == 0, -1.5e308, 1.5e308), TETS, "tetra"),
    "node 1 is not finite": (np.where(NODES == 0.05, np.nan, NODES), TETS, "tetra"),
}


@pytest.mark.parametrize("message", BAD)
def test_bad_meshes_are_refused_with_the_reason(tmp_path: Path, message: str) -> None:
    path = write(tmp_path / "bad.vtu", *BAD[message])
    with pytest.raises(MeshError, match=f"bad.vtu: .*{message}"):
        read_mesh(path)


SIZES = {
    "a node lies 5000.05 m from the origin, allowed is 1000 m": NODES + np.array([5e3, 0.0, 0.0]),
    "the body is 50 m long, expected 1 mm to 10 m; check the unit; "
    "in a unit 0.001 times as large it is 0.05 m; in a unit 0.01 times as large": 1e3 * NODES,
    "the body is 5e-05 m long, expected 1 mm to 10 m; check the unit; "
    "in a unit 1000 times as large it is 0.05 m$": 1e-3 * NODES,
    "the body is inf m long": np.where(NODES == 0, -1.5e308, 1.5e308),
}


@pytest.mark.parametrize("message", SIZES)
def test_sizes_of_no_robot_are_refused(message: str) -> None:
    with pytest.raises(MeshError, match=f"bad.vtu: .*{message}"):
        require_size(SIZES[message], 1.0, "bad.vtu", "the unit")


@pytest.mark.parametrize("scale", [1e-150, 1e-9, 1e9, 1e150])
def test_the_shape_of_elements_is_checked_in_any_unit(scale: float) -> None:
    """A mesh gets its scale only where it becomes a body."""
    assert len(checked(scale * NODES, TETS, "mesh").tets) == len(TETS)
    flat = NODES * [1.0, 1.0, 0.0]
    with pytest.raises(MeshError, match="1 flat tetrahedra, the first is 0"):
        checked(scale * flat, TETS, "mesh")


def test_files_that_are_no_mesh_are_refused(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "x.vtu").write_text("hello")
    (tmp_path / "x.nothing").write_text("hello")
    (tmp_path / "x.vtk").write_text("hello")
    reasons = {
        "x.vtu": r"not readable as a mesh \(it is cut off, .*\); export it again",
        "x.nothing": "no mesh format has the suffix '.nothing'; export tetrahedra as VTU, .*",
        "x.vtk": r"not readable as a mesh \(it is .*; meshio: Illegal VTK header\); export it again",
    }
    for name, reason in reasons.items():
        with pytest.raises(MeshError, match=f"{name}: {reason}$"):
            read_mesh(tmp_path / name)
    assert capfd.readouterr() == ("", ""), "meshio prints why it cannot read a file"
    with pytest.raises(MeshError, match="no such mesh file"):
        read_mesh(tmp_path / "missing.vtu")


def test_what_is_printed_while_meshes_are_read_in_threads_is_not_lost(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    inside, before = threading.Barrier(2), sys.stdout

    def read(path: Path) -> None:
        with suppress(threading.BrokenBarrierError):  # both at once, where they are let
            inside.wait(0.5)
        print(f"meshio about {path.name}")
        sys.exit(1)

    monkeypatch.setattr(meshio, "read", read)
    (tmp_path / "a.vtu").write_text("</VTKFile>")
    (tmp_path / "b.vtu").write_text("</VTKFile>")
    with ThreadPoolExecutor(2) as pool:
        tasks = [pool.submit(read_mesh, tmp_path / name) for name in ("a.vtu", "b.vtu")]
        while any(not task.done() for task in tasks):
            print("main", end=" ")
            time.sleep(0.01)
        for task, name in zip(tasks, "ab", strict=True):
            with pytest.raises(MeshError, match=rf"meshio: meshio about {name}.vtu\)"):
                task.result()
    assert sys.stdout is before
    print("and after")
    assert set(capsys.readouterr().out.split()) == {"main", "and", "after"}


def test_a_meshs_stream_may_be_deleted_after_the_one_before_is_closed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Python closes a stream that it deletes, in whatever thread, and complains where that raises."""
    before = io.TextIOWrapper(io.BytesIO())
    monkeypatch.setattr(sys, "stdout", before)
    streams = []

    def read(_path: Path) -> None:
        streams.append(sys.stdout)
        sys.exit(1)

    monkeypatch.setattr(meshio, "read", read)
    (tmp_path / "a.vtu").write_text("</VTKFile>")
    with ThreadPoolExecutor(1) as pool, suppress(MeshError):
        pool.submit(read_mesh, tmp_path / "a.vtu").result()
    before.close()
    (stream,) = streams
    stream.close()


def test_attached_points_are_where_they_were_put() -> None:
    mesh = box_mesh((0.1, 0.1, 0.1), (3, 2, 2))
    wanted = np.random.default_rng(0).uniform(0.0, 0.1, (40, 3))
    points = attach(mesh, wanted, "points")
    assert np.allclose(points.at(mesh.nodes), wanted)
    assert points.weights.min() > -1e-9


def test_points_outside_are_refused_or_extrapolated() -> None:
    mesh = box_mesh((0.1, 0.1, 0.1), (2, 2, 2))
    outside = np.array([[0.102, 0.05, 0.05]])
    with pytest.raises(ValueError, match=r"point 0 at .* lies 0.002 m outside the mesh"):
        attach(mesh, outside, "points")
    points = attach(mesh, outside, "points", max_outside=0.003)
    assert np.allclose(points.at(mesh.nodes), outside)


def test_points_outside_move_with_the_nearest_element() -> None:
    """Against the distance to every element by its own small quadratic program."""
    mesh = box_mesh((0.1, 0.02, 0.02), (6, 2, 2))
    points = np.random.default_rng(0).uniform([-0.02, -0.02, -0.02], [0.12, 0.04, 0.04], (30, 3))
    points = points[((points < 0.0) | (points > [0.1, 0.02, 0.02])).any(axis=1)]
    for point, nodes in zip(points, attach(mesh, points, "points", 0.1).nodes, strict=True):
        chosen = distance_to_hull(mesh.nodes[nodes], point)
        every = [distance_to_hull(mesh.nodes[tet], point) for tet in mesh.tets]
        assert chosen == pytest.approx(min(every), abs=1e-9)
        outside = np.linalg.norm(point - np.clip(point, 0.0, [0.1, 0.02, 0.02]))
        assert chosen == pytest.approx(outside, abs=1e-9)
        with pytest.raises(ValueError, match="outside the mesh"):
            attach(mesh, point[None], "points", 0.999 * outside)


def distance_to_hull(corners: Array, point: Array) -> float:
    """Distance of a point (3,) to the hull of corners (4, 3): non-negative weights whose sum is one."""
    heavy = 1e4 * np.ones((1, len(corners)))
    A, b = np.vstack([corners.T, heavy]), np.append(point, 1e4)
    weights, _ = nnls(A, b)
    return float(np.linalg.norm(weights @ corners / weights.sum() - point))
