"""`tauten check` of a robot with an object that nothing holds."""

from __future__ import annotations

from pathlib import Path

import meshio
import pytest
from support.robots.bodies import box_mesh

from tauten.model import Simulator, load_robot
from tauten.service.check import CheckSettings, check_robot
from tauten.service.check.robot_check import check_model
from tauten.service.process import StopFlag

SIZES = {"beam": (0.2, 0.02, 0.02), "cube": (0.02, 0.02, 0.02), "floor": (0.1, 0.1, 0.02)}
CELLS = {"beam": (10, 1, 1), "cube": (2, 2, 2), "floor": (1, 1, 1)}
ROBOT = """
name = "beam"
gravity = [0.0, 0.0, -9.81]
[material]
young_modulus = 1e6
poisson_ratio = 0.3
density = 1000.0
[[bodies]]
name = "beam"
mesh = { file = "beam.vtu" }
fixed = [{ lower = [0.0, 0.0, 0.0], upper = [0.0, 0.02, 0.02] }]
[[bodies]]
name = "cube"
mesh = { file = "cube.vtu" }
position = [0.0, 0.2, 0.0]
free = true
[[bodies]]
name = "floor"
mesh = { file = "floor.vtu" }
position = [-0.04, 0.16, -0.0205]
fixed = [{ kind = "all" }]
[[regions]]
name = "faces"
kind = "skin"
body = "cube"
[[regions]]
name = "top"
kind = "normal"
body = "floor"
direction = [0.0, 0.0, 1.0]
[[contacts]]
candidates = "faces"
against = "top"
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
basis = "full"
"""


def write(folder: Path, text: str = ROBOT) -> Path:
    """A robot file and its meshes."""
    for name, size in SIZES.items():
        mesh = box_mesh(size, CELLS[name])
        meshio.write(folder / f"{name}.vtu", meshio.Mesh(mesh.nodes, [("tetra", mesh.tets)]))
    path = folder / "beam.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_free_body_on_a_floor_is_not_wrong(tmp_path: Path) -> None:
    """It loads and runs; what needs a body that is held is left out, and said."""
    path = write(tmp_path)
    settings = CheckSettings(str(path), (0.1,))
    result = check_robot(settings, StopFlag(), lambda _share, _what: None)
    timed = "control step against period"  # of a computer that may do other things
    levels = {item.subject: item.level for item in result.findings}
    assert {level for subject, level in levels.items() if subject != timed} == {"fine"}, levels
    found = {item.subject: item.found for item in result.findings}
    said = "not looked at: by the robot file nothing holds cube but contact"
    assert found["sag and natural frequencies"] == found["error of the mesh"] == said
    assert result.estimate is None
    assert found["cables against their pulls"] == "the largest pull is 45.5 % of the cable"
    assert found["rates of actuators"] == "from rest to the farthest position in 0.5 s"
    simulator = Simulator(load_robot(path), contact="full")
    for _ in range(100):
        simulator.step(position=[0.0])
    assert simulator.lam_c.sum() == pytest.approx(9.81 * 1000.0 * 0.02**3, rel=0.02)


def test_a_free_body_that_no_contact_names_is_doubtful(tmp_path: Path) -> None:
    """The contact of the file is between bodies that are held: the cube falls."""
    text = ROBOT.replace('body = "cube"', 'body = "beam"')
    result = check_model(CheckSettings(str(write(tmp_path, text))), StopFlag(), lambda *_: None)
    finding = {item.subject: item for item in result.findings}["sag and natural frequencies"]
    assert finding.level == "doubtful"
    assert finding.found == "cube: free, and touched by no contact of the robot file"


@pytest.mark.parametrize("against", ["top", "table"])
def test_an_obstacle_that_no_contact_names_is_doubtful(against: str, tmp_path: Path) -> None:
    obstacle = """
[[obstacles]]
name = "table"
shape = "plane"
parameters = { point = [0.0, 0.0, -0.5], normal = [0.0, 0.0, 1.0] }
"""
    text = ROBOT.replace('against = "top"', f'against = "{against}"') + obstacle
    result = check_model(CheckSettings(str(write(tmp_path, text))), StopFlag(), lambda *_: None)
    found = [item for item in result.findings if item.subject == "obstacles"]
    assert [item.level for item in found] == ["doubtful"] * (against == "top")


@pytest.mark.parametrize(("lower", "level"), [(0.5, "fine"), (1.5, "doubtful"), (5.5, "wrong")])
def test_bodies_that_overlap_at_rest_are_found(lower: float, level: str, tmp_path: Path) -> None:
    """The cube, 0.5 mm above the floor in the file, is moved down [mm]; the alarm distance is 2 mm."""
    text = ROBOT.replace("[0.0, 0.2, 0.0]", f"[0.0, 0.2, {-1e-3 * lower}]")
    result = check_model(CheckSettings(str(write(tmp_path, text))), StopFlag(), lambda *_: None)
    finding = {item.subject: item for item in result.findings}["walls that may touch"]
    assert finding.level == level, finding
    if level != "fine":
        assert f"is {lower - 0.5:.3g} mm inside floor" in finding.found


@pytest.mark.parametrize("name", ["lift", "push"])
def test_objects_with_an_effector_are_no_robots_to_check_by_themselves(name: str) -> None:
    """What carries the effector has no actuator, what moves it no effector: both are said, and no more."""
    file = Path(__file__).parents[3] / "examples" / f"{name}.toml"
    result = check_model(CheckSettings(str(file)), StopFlag(), lambda _share, _what: None)
    assert not result.refused
    assert result.complete
    subjects = {found.subject.split(": ")[-1] for found in result.findings}
    assert subjects == {"no effector", "no actuator", "places of the parts", "free parts"}
    assert {found.level for found in result.findings} == {"fine"}
