"""`tauten check` on regions and several bodies: counts of each region, and a picture of them."""

from __future__ import annotations

from pathlib import Path

import meshio
import pytest
from support.processes import run_main
from support.robots.bodies import box_mesh

from tauten.service.check import CheckSettings, RobotCheck, check_robot, selected
from tauten.service.process import StopFlag

MESH = box_mesh((0.1, 0.02, 0.02), (8, 2, 2))
ROBOT = """
name = "pair"
[material]
young_modulus = 3e5
poisson_ratio = 0.4
total_mass = 0.05

[[bodies]]
name = "low"
mesh = { file = "box.vtu" }
fixed = [{ lower = [0.0, 0.0, 0.0], upper = [0.0, 0.02, 0.02] }]

[[bodies]]
name = "high"
mesh = { file = "box.vtu" }
position = [0.0, 0.0, 0.025]
fixed = [{ lower = [0.0, 0.0, 0.0], upper = [0.0, 0.02, 0.02] }]

[[regions]]
name = "top"
kind = "normal"
body = "low"
direction = [0.0, 0.0, 1.0]

[[regions]]
name = "nothing"
kind = "sphere"
centre = [1.0, 0.0, 0.0]
radius = 0.01

[[drives]]
name = "servo"
region = { lower = [0.0999, 0.0, 0.0], upper = [0.1, 0.02, 0.02] }
axis = [0.0, 1.0, 0.0]
through = [0.1, 0.0, 0.01]
max_angle = 0.2
max_torque = 1.0
max_rate = 1.0

[[effectors]]
name = "tip"
point = [0.1, 0.01, 0.02]
"""


@pytest.fixture
def robot(tmp_path: Path) -> str:
    meshio.write(tmp_path / "box.vtu", meshio.Mesh(MESH.nodes, [("tetra", MESH.tets)]))
    path = tmp_path / "pair.toml"
    path.write_text(ROBOT, encoding="utf-8")
    return str(path)


def checked(robot: str, **settings: object) -> RobotCheck:
    chosen = CheckSettings(robot, **settings)  # type: ignore[arg-type]
    return check_robot(chosen, StopFlag(), lambda _share, _what: None)


def test_regions_are_counted_and_empty_ones_named(robot: str) -> None:
    findings = {item.subject: item for item in checked(robot, shares=()).findings}
    top = findings["region top"]
    assert top.found == "27 nodes, 32 boundary triangles, 32 tetrahedra"
    assert findings["region nothing"].level == "doubtful"
    assert findings["region drives.0.region"].found.startswith("9 nodes")
    assert findings["moving mass"].found == "93.75 g"  # 100 g without the nodes that are fixed
    assert findings["loose parts of high"].level == "fine"
    assert findings["natural frequencies"].level != "wrong"


@pytest.mark.long
def test_meshes_are_compared_under_angles_of_drives(robot: str) -> None:
    estimate = checked(robot, shares=(0.5,)).estimate
    assert estimate is not None
    assert [load.label for load in estimate.loads] == ["servo 5.73 deg"]
    own = estimate.variants[0]
    assert own.effort is not None
    assert own.effort > 0.0  # linear elements are too stiff, whatever the sign of the torque


@pytest.mark.long
def test_the_command_draws_them(robot: str, tmp_path: Path) -> None:
    figure = tmp_path / "regions.png"
    assert run_main("check", robot, "--no-compare", "--regions", str(figure)) == 0
    assert figure.stat().st_size > 10_000
    _, parts = selected(robot)
    assert [part.name for part in parts] == ["top", "nothing", "drives.0.region"]


def test_a_mesh_that_is_not_there_is_said_with_robot_file_and_field(
    robot: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "box.vtu").unlink()
    assert run_main("--log-level", "error", "check", robot) == 2
    assert f"{robot}: bodies.0.mesh.file: no such file" in capsys.readouterr().err
