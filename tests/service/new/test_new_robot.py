"""`tauten new`: parts of CAD become robots that load and move; bad parts are refused in one sentence."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import meshio
import numpy as np
import pytest
from support.processes import run_main
from support.robots.bodies import box_mesh

from tauten.model import RobotFileError, Simulator, load_robot
from tauten.model.mesh import MeshError, TetMesh
from tauten.service.new import CadPart, NewRobot, PartError, make_new_robot, read_part
from tauten.service.new import make as making
from tauten.service.new import part as surfaces
from tauten.service.new.guesses import Guess, guess_fields
from tauten.service.process import StopFlag

BOX = np.array([[x, y, z] for x in (0, 12) for y in (0, 12) for z in (0, 60)], dtype=float)  # mm
SIDES = np.array(
    [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]]
)


def box(offset: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and triangles of a closed box, seen from outside counter-clockwise."""
    triangles = np.vstack([SIDES[:, [0, 1, 2]], SIDES[:, [0, 2, 3]]])
    corners = BOX[triangles]
    volume = np.einsum("ti,ti->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    return BOX + np.array(offset), triangles if volume > 0.0 else triangles[:, ::-1]


def write_stl(path: Path, vertices: np.ndarray, triangles: np.ndarray) -> Path:
    meshio.write(path, meshio.Mesh(vertices, [("triangle", triangles)]), binary=True)
    return path


def read(path: Path, unit: str = "mm", repair: bool = False) -> CadPart:
    return read_part(path, unit, repair)


def make(new: NewRobot, folder: Path) -> object:
    return make_new_robot(new, folder, StopFlag(), lambda done, what: None)


@pytest.mark.long
def test_a_box_becomes_a_robot_that_bends(tmp_path: Path) -> None:
    part = write_stl(tmp_path / "bar.stl", *box())
    made = make_new_robot(
        NewRobot("bar", read(part), size=9e-3),
        tmp_path / "bar",
        StopFlag(),
        lambda done, what: None,
    )
    robot = load_robot(made.file)
    assert len(made.trials) == 1 and np.isnan(made.trials[0].difference)
    sim = Simulator(robot, contact="none")
    sim.settle(position=[0.0])
    start = sim.effector[0]
    report = sim.settle(position=[float(robot.limits.position_max[0])])
    assert report.converged
    assert np.linalg.norm(sim.effector[0] - start) > 5e-3
    assert sim.effort[0] < robot.limits.effort_max[0]


@pytest.mark.slow
def test_the_size_is_chosen_by_the_error_of_the_mesh(tmp_path: Path) -> None:
    part = write_stl(tmp_path / "bar.stl", *box())
    made = make_new_robot(
        NewRobot("a", read(part), accuracy=0.2), tmp_path / "a", StopFlag(), lambda done, what: None
    )
    assert made.chosen < len(made.trials) - 1
    assert made.trials[made.chosen].difference <= 0.2
    # both ends and all four sides are equal: guesses of each mesh would hold or pull another one
    assert max(trial.difference for trial in made.trials[:-1]) < 0.15


@pytest.mark.long
def test_a_surface_that_is_inside_out_is_turned(tmp_path: Path) -> None:
    vertices, triangles = box()
    part = write_stl(tmp_path / "bar.stl", vertices, triangles[:, ::-1])
    made = make_new_robot(
        NewRobot("bar", read(part), size=9e-3),
        tmp_path / "bar",
        StopFlag(),
        lambda done, what: None,
    )
    assert "inside out" in made.notes[0]


@pytest.mark.long
def test_holes_are_refused_and_repaired(tmp_path: Path) -> None:
    vertices, triangles = box()
    part = write_stl(tmp_path / "open.stl", vertices, triangles[1:])
    with pytest.raises(PartError, match=r"open.stl: the surface has holes, 3 edges .*--repair"):
        read(part)
    pytest.importorskip("wildmeshing", reason="the extra repair has no wheels for this Python")
    new = NewRobot("bar", read(part, repair=True), size=9e-3)
    made = make_new_robot(new, tmp_path / "bar", StopFlag(), lambda done, what: None)
    assert load_robot(made.file).body.n_elements > 100


def test_triangles_that_cross_are_refused(tmp_path: Path) -> None:
    first, second = box(), box((6.0, 5.0, 7.0))
    vertices = np.vstack([first[0], second[0]])
    part = write_stl(tmp_path / "two.stl", vertices, np.vstack([first[1], second[1] + 8]))
    with pytest.raises(PartError, match="cross each other near"):
        make(NewRobot("two", read(part), size=9e-3), tmp_path / "two")


def test_a_surface_of_too_many_triangles_is_refused_before_it_is_searched(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(surfaces, "MOST_TRIANGLES", 11)
    with pytest.raises(
        PartError, match="has 12 triangles, allowed are 11; export it with a larger"
    ):
        read(write_stl(tmp_path / "bar.stl", *box()))


def test_a_triangle_that_is_turned_is_refused(tmp_path: Path) -> None:
    vertices, triangles = box()
    triangles = triangles.copy()
    triangles[0] = triangles[0, ::-1]
    part = write_stl(tmp_path / "turned.stl", vertices, triangles)
    with pytest.raises(PartError, match="inside out beside others"):
        make(NewRobot("turned", read(part), size=9e-3), tmp_path / "turned")


@pytest.mark.long
def test_an_assembly_is_refused_and_a_solid_is_meshed(tmp_path: Path) -> None:
    occ = pytest.importorskip("netgen.occ", reason="tauten[mesh] is not installed")
    solid = occ.Box((0, 0, 0), (12, 12, 60))
    solid.WriteStep(str(tmp_path / "one.step"))
    occ.Compound([solid, occ.Box((30, 0, 0), (42, 12, 60))]).WriteStep(str(tmp_path / "two.step"))
    with pytest.raises(PartError, match=r"two.step: holds 2 solids, one is needed"):
        make(NewRobot("two", read(tmp_path / "two.step"), size=9e-3), tmp_path / "two")
    made = make_new_robot(
        NewRobot("one", read(tmp_path / "one.step"), size=9e-3),
        tmp_path / "one",
        StopFlag(),
        lambda done, what: None,
    )
    volume = load_robot(made.file).body.mesh.volumes.sum()
    assert volume == pytest.approx(12e-3 * 12e-3 * 60e-3, rel=1e-6)


def test_files_that_hold_no_solid_say_so(tmp_path: Path) -> None:
    occ = pytest.importorskip("netgen.occ", reason="tauten[mesh] is not installed")
    occ.Compound([]).WriteStep(str(tmp_path / "empty.step"))
    occ.WorkPlane().Rectangle(12, 12).Face().WriteStep(str(tmp_path / "face.step"))
    for name in ("empty.step", "face.step"):
        with pytest.raises(PartError, match=rf"{name}: holds no solid; export the part as a solid"):
            read(tmp_path / name)
    (tmp_path / "bad.step").write_text("ISO-10303-21;\nEND-ISO-10303-21;\n")
    with pytest.raises(
        PartError, match=r"bad.step: not readable as a solid .*; export it again"
    ) as caught:
        read(tmp_path / "bad.step")
    assert "--size" not in str(caught.value)


@pytest.mark.long
def test_tetrahedra_of_a_file_are_taken_as_they_are(tmp_path: Path) -> None:
    mesh, file = box_mesh((0.012, 0.012, 0.06), (1, 1, 6)), tmp_path / "bar.vtu"
    meshio.Mesh(mesh.nodes, {"tetra": np.asarray(mesh.tets)}).write(file)
    made = make_new_robot(
        NewRobot("same", read(file, unit="m")),
        tmp_path / "same",
        StopFlag(),
        lambda done, what: None,
    )
    assert load_robot(made.file).n_nodes == len(mesh.nodes)


@pytest.mark.versions
def test_a_guess_that_makes_no_robot_is_told_without_a_temporary_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def far(meshes: list[TetMesh], chambers: bool) -> Guess:
        return replace(guess_fields(meshes, chambers), effector=np.ones(3))

    monkeypatch.setattr(making, "guess_fields", far)
    mesh, file = box_mesh((0.012, 0.012, 0.06), (1, 1, 6)), tmp_path / "bar.vtu"
    meshio.Mesh(mesh.nodes, {"tetra": np.asarray(mesh.tets)}).write(file)
    new = NewRobot("bar", read(file, unit="m"))
    told = r"^what was guessed for bar.toml: effectors.0.point: .*; turn or mend the part in CAD$"
    with pytest.raises(RobotFileError, match=told):
        make(new, tmp_path / "bar")
    assert not (tmp_path / "bar").exists()


@pytest.mark.parametrize("name", ["bar.stl", "bar.vtu"])
def test_a_part_in_another_unit_is_refused_with_the_option_that_says_it(
    tmp_path: Path, name: str
) -> None:
    if name == "bar.stl":
        file = write_stl(tmp_path / name, *box())
    else:
        mesh, file = box_mesh((12.0, 12.0, 60.0), (1, 1, 6)), tmp_path / name
        meshio.Mesh(mesh.nodes, {"tetra": np.asarray(mesh.tets)}).write(file)
    with pytest.raises(
        MeshError, match=r"60 m long, expected 1 mm to 10 m; check --unit; in a unit"
    ):
        read(file, unit="m")


def test_a_tiny_size_is_counted_before_it_is_meshed(tmp_path: Path) -> None:
    part = write_stl(tmp_path / "bar.stl", *box())
    assert NewRobot("bar", read(part), size=1e-4).elements > 1_000_000
    with pytest.raises(PartError, match="choose a --size above"):
        make(NewRobot("bar", read(part), size=1e-4), tmp_path / "bar")


@pytest.mark.versions
@pytest.mark.parametrize("size", ["inf", "nan", "1e5", "0"])
def test_a_size_of_no_element_is_refused(
    tmp_path: Path, size: str, capsys: pytest.CaptureFixture[str]
) -> None:
    part = write_stl(tmp_path / "bar.stl", *box())
    made = tmp_path / "bar"
    assert run_main("new", "bar", "--mesh", part, "--size", size, "--folder", made) == 2
    assert "--size" in capsys.readouterr().err
    assert not made.exists()


def test_a_folder_that_exists_is_not_touched(tmp_path: Path) -> None:
    part = write_stl(tmp_path / "bar.stl", *box())
    (tmp_path / "bar").mkdir()
    with pytest.raises(PartError, match="exists already"):
        make(NewRobot("bar", read(part)), tmp_path / "bar")


@pytest.mark.parametrize("contents", [b"", b"solid x\nendsolid x\n", b"\x00" * 84, b"not a mesh"])
def test_files_that_hold_no_surface(tmp_path: Path, contents: bytes) -> None:
    part = tmp_path / "bad.stl"
    part.write_bytes(contents)
    with pytest.raises(ValueError, match=r"bad.stl"):
        make(NewRobot("bad", read(part)), tmp_path / "bad")
    assert not (tmp_path / "bad").exists()
