"""`tauten check` of robots of parts: places of the parts, and free ones that nothing touches."""

from __future__ import annotations

from pathlib import Path

import meshio
import pytest
from support.processes import run_main
from support.robots.bodies import box_mesh
from support.robots.my_package import installed

from tauten.model.numerics import Array
from tauten.service.check import CheckSettings, Finding, mesh_error_text
from tauten.service.check.robot_check import check_model
from tauten.service.process import StopFlag

MATERIAL = """
[material]
young_modulus = 1e6
poisson_ratio = 0.3
density = 1000.0
"""
BEAM = f"""
name = "beam"
{MATERIAL}
[mesh]
file = "beam.vtu"
[[fixed]]
lower = [0.0, 0.0, 0.0]
upper = [0.0, 0.02, 0.02]
[[cables]]
name = "tendon"
points = [[0.0, 0.01, 0.015], [0.2, 0.01, 0.015]]
max_tension = 10.0
max_pull = 0.01
max_rate = 0.1
[[effectors]]
name = "tip"
point = [0.2, 0.01, 0.01]
"""
CUBE = f"""
name = "cube"
{MATERIAL}
[[bodies]]
name = "cube"
mesh = {{ file = "cube.vtu" }}
rigid = true
free = true
"""
BOTH = """
name = "both"
[[parts]]
name = "arm"
robot = "beam.toml"
[[parts]]
name = "cube"
robot = "cube.toml"
position = [0.05, 0.005, HEIGHT]
[[obstacles]]
name = "floor"
shape = "plane"
parameters = { point = [0.0, 0.0, -0.2], normal = [0.0, 0.0, 1.0] }
[[contacts]]
candidates = { part = "TOUCHED" }
against = "floor"
"""


HOOP = """
[[obstacles]]
name = "hoop"
shape = "ring"
parameters = { centre = [0.0, 0.0, -0.1], axis = [1.0, 0.0, 0.0], radius = 0.02, thickness = 0.01 }
[[contacts]]
candidates = { part = "arm" }
against = "hoop"
points = "vertices"
"""


def findings(folder: Path, height: float, touched: str, more: str = "") -> dict[str, Finding]:
    """What is found of a beam up to z = 20 mm and a cube above it, by subject.

    Args:
        folder: of the robot files.
        height: of the lowest face of the cube [m].
        touched: the part whose contact with the floor is in the file.
        more: other tables of the file of both.
    """
    for name, size, cells in (
        ("beam", (0.2, 0.02, 0.02), (8, 1, 1)),
        ("cube", (0.01, 0.01, 0.01), (1, 1, 1)),
    ):
        mesh = box_mesh(size, cells)
        meshio.write(folder / f"{name}.vtu", meshio.Mesh(mesh.nodes, [("tetra", mesh.tets)]))
    for name, text in (
        ("beam", BEAM),
        ("cube", CUBE),
        ("both", BOTH.replace("HEIGHT", f"{height:g}").replace("TOUCHED", touched) + more),
    ):
        (folder / f"{name}.toml").write_text(text, encoding="utf-8")
    settings = CheckSettings(str(folder / "both.toml"), ())
    result = check_model(settings, StopFlag(), lambda *_: None)
    assert not result.refused
    return {item.subject: item for item in result.findings}


@pytest.mark.parametrize(
    ("height", "level"), [(0.021, "fine"), (0.02, "fine"), (0.019, "doubtful")]
)
def test_parts_that_no_contact_joins_and_that_overlap_are_found(
    tmp_path: Path, height: float, level: str
) -> None:
    """The loader refuses overlaps of surfaces of a contact; others went through each other unseen."""
    found = findings(tmp_path, height, "cube")
    finding = found["places of the parts"]
    assert finding.level == level, finding
    if level != "fine":
        assert "at rest cube is 1 mm inside arm" in finding.found
    assert found["free parts"].level == "fine"


def test_a_free_part_that_no_contact_names_is_doubtful(tmp_path: Path) -> None:
    finding = findings(tmp_path, 0.021, "arm")["free parts"]
    assert finding.level == "doubtful"
    assert finding.found == "cube: free, and touched by no contact of the robot file"


@pytest.mark.long
def test_reports_do_not_ask_for_errors_that_the_check_does_not_have(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """They named a command that refuses to save what there is not."""
    findings(tmp_path, 0.021, "cube")
    both, cube = tmp_path / "both.toml", tmp_path / "cube.toml"
    why = "meshes of parts are compared by themselves, with tauten check of their files"
    assert mesh_error_text(both, "") == f"not looked at: {why}"
    assert mesh_error_text(cube, "") == "not looked at: nothing holds cube but contact"
    assert "run tauten check" in mesh_error_text(tmp_path / "beam.toml", "")
    assert run_main("--log-level", "error", "check", both, "--no-compare", "--save") == 2
    assert "without a comparison of meshes; meshes of parts" in " ".join(
        line.strip("│ ") for line in capsys.readouterr().err.splitlines()
    )


@pytest.mark.parametrize(("sign", "level"), [(1.0, "fine"), (-1.0, "wrong")])
def test_shapes_of_other_packages_are_compared(
    sign: float, level: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of obstacles of the file of all parts nothing was said, whatever normals they gave."""
    (tmp_path / "package").mkdir()
    with installed(tmp_path / "package") as package:
        usual = package.Ring.closest

        def closest(ring: object, points: Array) -> tuple[Array, Array]:
            gap, normal = usual(ring, points)
            return gap, sign * normal

        monkeypatch.setattr(package.Ring, "closest", closest)
        found = findings(tmp_path, 0.021, "cube", HOOP)["derivatives of extensions"]
    assert found.level == level
    assert "normals of hoop" in found.found
