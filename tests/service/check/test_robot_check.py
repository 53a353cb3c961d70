"""`tauten check` on a beam: its error against a fine answer, and what may be wrong with its file."""

from __future__ import annotations

import json
import re
from pathlib import Path

import meshio
import numpy as np
import pytest
from support.processes import run_main
from support.robots.bodies import box_mesh
from support.robots.examples import shipped_robot
from support.robots.joined import linked
from support.robots.thumb import coarse_finger_mesh

from tauten.model import Simulator, load_robot
from tauten.model.load import robot_path
from tauten.model.mesh import TetMesh
from tauten.model.schema import RobotConfig
from tauten.service.check import (
    CheckSettings,
    Finding,
    RobotCheck,
    Variant,
    check_robot,
    mesh_error_text,
    robot_check,
)
from tauten.service.check.body_findings import body_findings
from tauten.service.check.certificate import certificate_file
from tauten.service.check.contact_findings import thin_walls
from tauten.service.process import StopFlag
from tauten.service.tables import check_page

SIZE = (0.2, 0.02, 0.02)
CELLS = (10, 1, 1)
REACH = 0.18  # m from the fixed end to the cable
BEAM = """
name = "beam"
gravity = [0.0, 0.0, 0.0]
[mesh]
file = "beam.vtu"
[material]
young_modulus = 1e6
poisson_ratio = 0.3
density = 1000.0
[[fixed]]
lower = [0.0, 0.0, 0.0]
upper = [0.0, 0.02, 0.02]
[[cables]]
name = "tendon"
pull_point = [0.18, 0.01, -0.1]
points = [[0.18, 0.01, 0.01]]
max_tension = 100.0
max_pull = 0.05
max_rate = 0.1
[[effectors]]
name = "tip"
point = [0.2, 0.01, 0.01]
[controller]
rate = 200.0
"""


def write(folder: Path, mesh: TetMesh | None = None, *changes: tuple[str, str]) -> str:
    """A robot file and its mesh in a folder: its path."""
    mesh = mesh or box_mesh(SIZE, CELLS)
    meshio.write(folder / "beam.vtu", meshio.Mesh(mesh.nodes, [("tetra", mesh.tets)]))
    text = BEAM
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path = folder / "beam.toml"
    path.write_text(text, encoding="utf-8")
    return str(path)


def checked(robot: str, **settings: object) -> RobotCheck:
    """The check of a robot, by default without comparison of meshes."""
    chosen = {"shares": (), **settings}
    return check_robot(CheckSettings(robot, **chosen), StopFlag(), lambda _share, _what: None)  # type: ignore[arg-type]


def about(result: RobotCheck, subject: str) -> Finding:
    """The line about a subject."""
    (found,) = (item for item in result.findings if item.subject == subject)
    return found


@pytest.mark.long
@pytest.mark.parametrize(
    ("refinements", "source"), [(1, "quadratic"), pytest.param(2, "linear", marks=pytest.mark.slow)]
)
def test_the_error_of_a_coarse_cantilever_is_that_against_beam_theory(
    tmp_path: Path, refinements: int, source: str
) -> None:
    """2 mm of pull across a beam of 180 mm: F = 3 E I δ / a³; two elements over the thickness."""
    robot = write(tmp_path, box_mesh(SIZE, (10, 2, 2)))
    result = checked(robot, shares=(0.04,), refinements=refinements)
    simulator = Simulator(load_robot(robot), contact="none")
    assert simulator.settle(position=[0.002], tolerance=1e-8).converged
    theory = 3.0 * 1e6 * (0.02**4 / 12.0) * 0.002 / REACH**3
    error = simulator.effort[0] / theory - 1.0
    assert error > 0.5
    estimate = result.estimate
    assert estimate is not None
    assert estimate.complete
    own = estimate.variants[0]
    assert own.effort == pytest.approx(error, rel=0.15)
    assert own.contact is None
    (reference,) = estimate.references
    assert reference is not None
    assert reference.source.startswith(source)
    assert reference.state.effort[0] == pytest.approx(theory, rel=0.06)
    assert (reference.order is not None) == (refinements == 2)
    if (
        refinements == 2
    ):  # the tip hardly moves along with the mesh: no order, see `reference_state`
        assert (
            reference.source == "linear meshes extrapolated (tip: quadratic elements, refined once)"
        )
    assert own.level == result.level == "wrong"
    assert "linear elements are too stiff" in estimate.verdict
    assert "mesh.element = " in estimate.advice


def test_a_sound_robot_is_fine(tmp_path: Path) -> None:
    """With two elements over the thickness; one is too stiff by half, see the test above."""
    thin = about(checked(write(tmp_path)), "elements over the thickness")
    assert thin.level == "doubtful"
    assert thin.found.startswith("100 % of the volume")
    result = checked(write(tmp_path, box_mesh(SIZE, (10, 2, 2))))
    body = [item for item in result.findings if not item.subject.startswith("control step")]
    assert [item.level for item in body] == ["fine"] * (len(result.findings) - 1)
    assert result.estimate is None
    nodes_that_move = 1000.0 * 0.2 * 0.02 * 0.02 * 1e3
    mass = float(about(result, "moving mass").found.split()[0])
    assert 0.8 * nodes_that_move < mass < nodes_that_move
    assert "1.00 at" not in about(result, "shape of elements").found


def test_a_wrong_unit_is_said(tmp_path: Path) -> None:
    """A mesh in millimetres: too long for any robot, or only too long for its cables."""
    for scale, size in ((1e3, "2e+05 mm"), (100.0, "2e+04 mm")):
        mesh = box_mesh(SIZE, CELLS)
        result = checked(write(tmp_path, TetMesh(scale * mesh.nodes, mesh.tets)))
        found = about(result, "length unit")
        assert found.level == "wrong"
        assert size in found.found
        assert f"set mesh.length_unit = {'mm' if scale > 500.0 else 'cm'!r}" in found.advice
        assert result.refused
        assert result.level == "wrong"


@pytest.mark.long
def test_soft_and_heavy_sags_and_vibrates_slowly(tmp_path: Path) -> None:
    changes = (("gravity = [0.0, 0.0, 0.0]", "gravity = [0.0, 0.0, -9.81]"), ("= 1e6", "= 5e5"))
    found = about(checked(write(tmp_path, None, *changes)), "sag under gravity")
    assert found.level == "doubtful"
    assert "young_modulus" in found.advice
    slow = about(checked(write(tmp_path, None, ("200.0", "20.0"))), "natural frequencies")
    assert slow.level == "doubtful"
    assert "controller.rate = " in slow.advice
    static = ("rate = 200.0", 'rate = 200.0\n[integration]\nscheme = "quasi-static"')
    left_out = about(checked(write(tmp_path, None, static)), "natural frequencies")
    assert "quasi-static" in left_out.advice


def test_bad_elements_parts_and_points_are_all_named_at_once(tmp_path: Path) -> None:
    mesh = box_mesh(SIZE, CELLS)
    tets = mesh.tets.copy()
    tets[7] = tets[7][[0, 2, 1, 3]]
    island = box_mesh((0.01, 0.01, 0.01), (1, 1, 1))
    broken = TetMesh(
        np.vstack([mesh.nodes, island.nodes + np.array([0.0, 0.0, 0.03])]),
        np.vstack([tets, island.tets + len(mesh.nodes)]),
    )
    result = checked(write(tmp_path, broken, ("point = [0.2, 0.01,", "point = [0.205, 0.01,")))
    assert "1 inverted, 0 flat, the worst is 7" in about(result, "shape of elements").found
    assert about(result, "loose parts").found.startswith("2 parts")
    outside = about(result, "cables and effectors")
    assert outside.found.startswith(
        "1 of 2 points outside of the mesh, effectors.0.point by at least"
    )
    assert 2.0 < float(outside.found.split()[-2]) <= 5.0
    levels = {item.subject: item.level for item in result.findings}
    assert levels["shape of elements"] == levels["loose parts"] == outside.level == "wrong"
    assert "inverted" in result.refused


@pytest.mark.long
@pytest.mark.parametrize(
    ("alarm", "against", "level"),
    [(0.015, "bottom", "fine"), (0.025, "bottom", "wrong"), (0.025, "itself", "fine")],
)
def test_walls_thinner_than_the_alarm_distance_are_found(
    alarm: float, against: str, level: str, tmp_path: Path
) -> None:
    """A body of 20 mm; a contact of its top with itself never finds its bottom, and was called wrong."""
    surfaces = f"""
[[surfaces]]
name = "top"
box = {{ lower = [0.0, 0.0, 0.02], upper = [0.2, 0.02, 0.02] }}
[[surfaces]]
name = "bottom"
box = {{ lower = [0.0, 0.0, 0.0], upper = [0.2, 0.02, 0.0] }}
[[contacts]]
candidates = "top"
against = "{against}"
points = 4
[contact]
alarm_distance = {alarm}
"""
    added = ("[controller]", surfaces + "[controller]")
    found = about(checked(write(tmp_path, None, added)), "walls that may touch")
    assert found.level == level
    assert found.found.startswith("20 mm at least")
    assert ("alarm_distance below 0.02 m" in found.advice) == (level == "wrong")
    assert ("top on bottom has both sides of a wall of 20 mm" in found.found) == (level == "wrong")


def test_the_walls_of_shipped_robots_are_fine() -> None:
    """Folds of the pneumatic finger touch themselves; the other sides of their walls are of its chamber."""
    found = thin_walls(robot := shipped_robot("pneumatic_finger"), robot.contacts.alarm_distance)
    assert found.level == "fine"
    assert found.found.endswith("and no contact has both sides of one")


def test_a_stop_keeps_what_is_done(tmp_path: Path) -> None:
    stop, seen = StopFlag(), []

    def progress(_share: float, what: str) -> None:
        seen.append(what)
        if seen.count("quadratic") == 2:
            stop.request()

    settings = CheckSettings(write(tmp_path), (0.1, 0.2, 0.3), 1)
    result = check_robot(settings, stop, progress)
    assert result.estimate is not None
    assert not result.complete
    assert [len(item.states) for item in result.estimate.states] == [3, 2]
    assert [item is not None for item in result.estimate.references] == [True, True, False]
    assert "too stiff" in result.estimate.verdict


@pytest.mark.long
def test_the_command_writes_all_its_files(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    robot, numbers = write(tmp_path), tmp_path / "check.json"
    figure, page = tmp_path / "check.png", tmp_path / "page.md"
    page.write_text("before\n<!-- tauten check -->\nold\n<!-- end -->\nafter\n")
    options = ("--json", numbers, "--figure", figure, "--markdown", page, "--share", "0.2")
    assert run_main("--log-level", "error", "check", robot, *options) == 1
    assert "linear elements are too stiff" in " ".join(capsys.readouterr().out.split())
    written = json.loads(numbers.read_text(encoding="utf-8"))
    assert written["level"] == "wrong"
    assert written["estimate"]["variants"][0]["effort"] > 0.1
    assert figure.read_bytes().startswith(b"\x89PNG")
    assert "| linear | 44 |" in page.read_text(encoding="utf-8")
    assert run_main("--log-level", "error", "check", robot, "--no-compare") == 0


def test_a_robot_that_cannot_be_built_is_one_sentence_after_the_findings(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mesh = box_mesh(SIZE, CELLS)
    robot = write(tmp_path, TetMesh(1e3 * mesh.nodes, mesh.tets))
    assert run_main("--log-level", "error", "check", robot) == 2
    said = capsys.readouterr()
    assert "length_unit = 'mm'" in said.out
    assert len(said.err.strip().splitlines()) == 1
    assert "check mesh.length_unit" in said.err


@pytest.mark.long
def test_a_coarse_finger_is_too_stiff_with_linear_elements(tmp_path: Path) -> None:
    mesh = coarse_finger_mesh()
    meshio.Mesh(mesh.nodes, [("tetra", mesh.tets)]).write(tmp_path / "finger.vtu")
    text = robot_path("finger").read_text(encoding="utf-8")
    copy = tmp_path / "finger.toml"
    copy.write_text(re.sub(r"(?m)^element = .*$", "", text), encoding="utf-8")
    result = checked(str(copy), shares=(0.1,), refinements=0)
    assert result.estimate is not None
    assert "linear elements are too stiff" in result.estimate.verdict
    own = result.estimate.variants[0]
    assert own.variant == Variant("linear", 0)
    assert own.effort is not None
    assert own.effort > 0.2


def test_errors_are_saved_for_the_robot_that_was_checked(tmp_path: Path) -> None:
    path = Path(write(tmp_path))
    digest = load_robot(path).digest
    assert mesh_error_text(path, digest) == f"unknown, run tauten check {path} --save"
    options = ("--share", "0.2", "--refinements", "0", "--save")
    assert run_main("--log-level", "error", "check", path, *options) == 1
    own = checked(str(path), shares=(0.2,), refinements=0).estimate
    assert own is not None
    assert own.variants[0].effort is not None
    said = mesh_error_text(path, digest)
    assert said.startswith(f"tension {100.0 * own.variants[0].effort:+.1f} %, tip ")
    assert "tauten check, 20" in said
    other = load_robot(path, young_scale=1.1).digest
    assert mesh_error_text(path, other).startswith(
        "unknown since the robot was changed (materials), "
    )
    certificate_file(path).write_text('{"effort": 1.0}', encoding="utf-8")
    assert "cannot be read" in mesh_error_text(path, digest)


def test_the_command_named_checks_the_file_that_is_reported(tmp_path: Path) -> None:
    """A robot file of one's own may have the name of a shipped robot, and its folder spaces."""
    own = tmp_path / "my robots" / "trunk.toml"
    assert mesh_error_text(own, "") == f"unknown, run tauten check '{own}' --save"
    assert mesh_error_text(robot_path("trunk"), "").endswith("run tauten check trunk --save")


def test_errors_that_are_not_known_are_not_saved(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = Path(write(tmp_path))
    assert run_main("--log-level", "error", "check", path, "--no-compare", "--save") == 2
    assert "no errors without a comparison" in " ".join(capsys.readouterr().err.split())
    assert not certificate_file(path).exists()


@pytest.mark.long
def test_where_no_mesh_is_fine_the_better_element_is_named(tmp_path: Path) -> None:
    """One element over the thickness: no mesh comes within 3 % of the extrapolated tension."""
    estimate = checked(write(tmp_path), shares=(0.04,), refinements=2).estimate
    assert estimate is not None
    assert all(item.level != "fine" for item in estimate.variants)
    start = "refine the mesh where strain is large; mesh.element = 'quadratic' alone leaves tension"
    assert estimate.advice.startswith(start)


def test_a_stop_on_the_first_mesh_gives_no_verdict(tmp_path: Path) -> None:
    stop = StopFlag()
    settings = CheckSettings(write(tmp_path), (0.1, 0.2), 1)
    result = check_robot(settings, stop, lambda _share, what: stop.request())
    assert not result.complete
    assert result.level == "doubtful"
    assert result.estimate is not None
    assert result.estimate.verdict == "stopped before a better mesh was compared"


@pytest.mark.slow
def test_an_equilibrium_that_is_not_found_is_said(tmp_path: Path) -> None:
    """A cable of 0.11 m that is to be 0.3 m shorter."""
    robot = write(tmp_path, None, ("max_pull = 0.05", "max_pull = 0.3"))
    result = checked(robot, shares=(0.1, 1.0), refinements=0)
    assert result.estimate is not None
    own = result.estimate.variants[0]
    assert own.unsettled == 1
    assert own.level == "wrong"
    assert "1 of 2 equilibria not found" in result.estimate.verdict


def test_a_mesh_that_fails_does_not_cost_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What was compared before and after it is reported, and the failure is a line among others."""
    made = robot_check.variant_robot

    def failing(config: RobotConfig, path: Path, variant: Variant) -> object:
        if variant.element == "smoothed":
            raise NotImplementedError("no smoothed elements today")
        return made(config, path, variant)

    monkeypatch.setattr(robot_check, "variant_robot", failing)
    result = checked(write(tmp_path), shares=(0.04,))
    assert result.complete
    assert result.estimate is not None
    efforts = {item.variant.name: item.effort for item in result.estimate.variants}
    assert efforts.pop("smoothed") is None
    assert len(efforts) == 3
    assert None not in efforts.values()
    failed = about(result, "meshes to compare with")
    assert failed.level == "doubtful"
    assert failed.found == "smoothed elements: NotImplementedError: no smoothed elements today"
    assert "no smoothed elements today" in check_page(result).tables[0].markdown()


@pytest.mark.parametrize("links", [1, 3])
def test_links_that_only_tendons_hold_do_not_sag(links: int) -> None:
    """They hung from their hinges, tendons slack: `wrong`, with Young's modulus to be checked, and fixed."""
    robot = linked(links, {"min_pull": -0.004}, gravity=[0.0, 0.0, -9.81], integration={})
    found = {item.subject: item for item in body_findings(robot)}
    sag, vibration = found["sag under gravity"], found["natural frequencies"]
    assert sag.level == vibration.level == "fine"
    assert float(sag.found.split()[0]) < 0.01  # mm
    assert vibration.found == "not looked at: nothing but cables holds the body"
