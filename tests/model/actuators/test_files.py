"""Chambers, forces and couplings in robot files: what is found, what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from support.robots.bodies import (
    CABLE,
    CHAMBER,
    HOLLOW_SIZE,
    box_mesh,
    hollow_beam,
    pneumatic_config,
    pneumatic_robot,
    without,
)

from tauten.model import Robot
from tauten.model.load import build_robot, load_robot
from tauten.model.mesh import TetMesh
from tauten.model.numerics import Ints
from tauten.model.schema import RobotConfig, RobotFileError, validated
from tauten.model.tetra import NodalBody
from tauten.service.check import CheckSettings, check_robot
from tauten.service.process import StopFlag

PLACE = {name: value for name, value in CHAMBER.items() if name != "inside"}
PUSH = {"name": "push", "point": [0.1, 0.01, 0.01], "direction": [0.0, 3.0, 4.0],
        "max_force": 1.0, "max_travel": 0.1, "max_rate": 1.0}  # fmt: skip
CAVITY = {"lower": [0.0099, 0.0049, 0.0099], "upper": [0.0901, 0.0151, 0.0151]}
DRUM = {"name": "drum", "members": ["tendon"], "gains": [1.0], "max_position": 0.02,
        "max_effort": 5.0, "max_rate": 0.1}  # fmt: skip


def built(**changes: object) -> Robot[NodalBody]:
    """A robot of a file with changes; what is wrong raises as a file does."""
    config = validated(RobotConfig, pneumatic_config(**changes), "balloon.toml")
    return build_robot(config, hollow_beam(), "balloon.toml")


def surface_of(robot: Robot[NodalBody]) -> set[tuple[int, ...]]:
    return {tuple(sorted(triangle)) for triangle in robot.actuator_set.chambers.nodes.tolist()}


def file_with_stl(folder: Path, mesh: TetMesh, triangles: Ints) -> Path:
    """A robot file whose chamber is the one nearest to these triangles in an STL file."""
    meshio.write_points_cells(folder / "cavity.stl", 1e3 * mesh.nodes, [("triangle", triangles)])
    meshio.write_points_cells(folder / "body.vtu", mesh.nodes, [("tetra", mesh.tets)])
    text = """
        name = "balloon"
        mesh = { file = "body.vtu" }
        material = { young_modulus = 5e5, poisson_ratio = 0.3, density = 1000.0 }
        fixed = [{ lower = [0.0, 0.0, 0.0], upper = [0.0, 0.02, 0.02] }]
        effectors = [{ name = "tip", point = [0.1, 0.01, 0.01] }]
        [[chambers]]
        name = "bellows"
        stl = "cavity.stl"
        stl_unit = "mm"
        max_pressure = 4e4
        max_volume_change = 8e-6
        max_rate = 2e-5
    """
    file = folder / "balloon.toml"
    file.write_text(text)
    return file


def test_three_ways_to_name_a_cavity_give_the_same_surface(tmp_path: Path) -> None:
    mesh = hollow_beam()
    inside = pneumatic_robot(mesh)
    triangles = inside.actuator_set.chambers.nodes
    box = built(surfaces=[{"name": "wall", "box": CAVITY}], chambers=[{**PLACE, "surface": "wall"}])
    stl = load_robot(file_with_stl(tmp_path, mesh, triangles))
    assert isinstance(stl.body, NodalBody)
    assert surface_of(inside) == surface_of(box) == surface_of(stl)
    assert len(surface_of(inside)) == len(triangles) > 0


@pytest.mark.parametrize("turned", [False, True])
def test_a_surface_that_is_inside_out_is_turned_and_said(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, turned: bool
) -> None:
    mesh = hollow_beam()
    triangles = pneumatic_robot(mesh).actuator_set.chambers.nodes
    file = file_with_stl(tmp_path, mesh, triangles[:, ::-1] if turned else triangles)
    robot = load_robot(file)
    assert isinstance(robot.body, NodalBody)
    assert robot.actuator_set.chambers.rest_volume[0] > 0.0
    assert ("cavity.stl is inside out: its normals point into" in caplog.text) is turned
    checked = check_robot(CheckSettings(str(file), shares=()), StopFlag(), lambda share, text: None)
    (finding,) = (item for item in checked.findings if item.subject == "chamber bellows")
    assert finding.level == ("doubtful" if turned else "fine")


def test_of_two_cavities_the_one_around_the_point_is_taken() -> None:
    sides = [np.array([0.0, 0.005, 0.01]), np.array([0.0, 0.015, 0.015])]
    shifts = [np.array([[0.01, 0, 0], [0.04, 0, 0]]), np.array([[0.05, 0, 0], [0.09, 0, 0]])]
    mesh = without(
        box_mesh(HOLLOW_SIZE, (10, 4, 4)),
        [(sides[0] + low, sides[1] + high) for low, high in shifts],
    )
    robot = pneumatic_robot(mesh, chambers=[{**PLACE, "inside": [0.07, 0.01, 0.0125]}])
    assert robot.actuator_set.chambers.rest_volume == pytest.approx([0.04 * 0.01 * 0.005])


@pytest.mark.parametrize(
    ("tables", "position", "effort"),
    [
        (
            {"chambers": [
                {**CHAMBER, "min_pressure": -1e4, "max_pressure": 0.0, "min_volume_change": -1e-6,
                 "max_volume_change": 0.0},
            ]}, (-1e-6, 0.0), (-1e4, 0.0),
        ),
        (
            {"forces": [
                {**PUSH, "min_force": -2.0, "max_force": 0.0, "min_travel": -0.01, "max_travel": 0.0},
            ]}, (-0.01, 0.0), (-2.0, 0.0),
        ),
        (
            {"forces": [
                {**PUSH, "min_force": 0.0, "max_force": 2.0, "min_travel": 0.0, "max_travel": 0.01},
            ]}, (0.0, 0.01), (0.0, 2.0),
        ),
    ],
)  # fmt: skip
def test_limits_may_lie_on_one_side_of_rest(
    tables: dict[str, Any], position: tuple[float, float], effort: tuple[float, float]
) -> None:
    """A vacuum, a force that only pushes; the farthest position is the limit that is not zero."""
    limits = pneumatic_robot(**{"chambers": [], **tables}).limits
    assert (limits.position_min[0], limits.position_max[0]) == position
    assert (limits.effort_min[0], limits.effort_max[0]) == effort
    assert limits.farthest_position[0] == position[0] + position[1]


REFUSED: list[tuple[dict[str, Any], str]] = [
    ({"chambers": [PLACE]}, "found none of surface, stl and inside"),
    ({"chambers": [{**CHAMBER, "surface": "wall"}]}, "found surface and inside of surface"),
    ({"chambers": [{**CHAMBER, "inside": [0.05, 0.01, 0.002]}]}, "lies in none of the 1 cavities"),
    ({"chambers": [{**PLACE, "surface": "wall"}]}, "region 'wall' is not defined, known are none"),
    ({"chambers": [{**PLACE, "stl": "none.stl"}]}, "no such mesh file"),
    ({"chambers": [{**CHAMBER, "min_pressure": 10.0}]}, "must have zero, the value at rest"),
    ({"chambers": [{**CHAMBER, "max_volume_change": -1.0}]}, "greater than or equal to 0"),
    ({"chambers": [{**CHAMBER, "held": "tightly"}]}, "held"),
    ({"chambers": [{**CHAMBER, "stl_unit": "mm"}]}, "stl_unit is given without stl"),
    ({"chambers": []}, "a robot needs an actuator"),
    ({"chambers": [CHAMBER, CHAMBER]}, "name 'bellows' is used twice"),
    ({"forces": [{**PUSH, "name": "bellows"}]}, "name 'bellows' is used twice"),
    ({"forces": [{**PUSH, "direction": [0.0, 0.0, 0.0]}]}, "direction"),
    ({"forces": [{**PUSH, "region": CAVITY}]}, "give either point or region"),
    ({"forces": [{**PUSH, "point": [0.5, 0.0, 0.0]}]}, r"forces.push.point: .* outside the mesh"),
    ({"forces": [{**PUSH, "point": None, "region": {"lower": [1, 1, 1], "upper": [2, 2, 2]}}]},
     r"forces.push.region: no node in"),
    ({"couplings": [DRUM]}, "member 'tendon' is not defined, known are bellows"),
    ({"cables": [CABLE], "couplings": [{**DRUM, "gains": [0.0]}]}, "at least 1e-9 in magnitude"),
    ({"cables": [CABLE], "couplings": [{**DRUM, "gains": [1.0, 1.0]}]}, "found 2 gains for 1 members"),
    ({"cables": [CABLE], "couplings": [DRUM, {**DRUM, "name": "b"}]}, "driven by another coupling"),
    ({"cables": [CABLE], "couplings": [{**DRUM, "members": ["tendon", "bellows"], "gains": [1, 1]}]},
     "the members of a coupling are of one kind"),
    ({"cables": [{**CABLE, "spring": {"stiffness": 0.0}}]}, "spring.stiffness"),
    ({"cables": [{**CABLE, "spring": {"stiffness": 1.0, "pretension": -1.0}}]}, "spring.pretension"),
]  # fmt: skip


@pytest.mark.parametrize(("changes", "text"), REFUSED)
def test_what_is_wrong_is_one_sentence(changes: dict[str, Any], text: str) -> None:
    with pytest.raises(RobotFileError, match=text) as caught:
        built(**changes)
    assert str(caught.value).startswith("balloon.toml: ")
    assert "\n" not in str(caught.value)


def test_a_surface_with_a_hole_is_refused() -> None:
    lower, upper = CAVITY["lower"], [0.06, *CAVITY["upper"][1:]]
    wall = {"name": "wall", "box": {"lower": lower, "upper": upper}}
    with pytest.raises(RobotFileError, match=r"chambers\.bellows: the surface of .* is not closed"):
        built(surfaces=[wall], chambers=[{**PLACE, "surface": "wall"}])


def test_the_outside_of_the_body_is_no_chamber() -> None:
    solid = box_mesh(HOLLOW_SIZE, (5, 2, 2))
    everything = {"name": "skin", "box": {"lower": [-1.0] * 3, "upper": [1.0] * 3}}
    with pytest.raises(RobotFileError, match="encloses the body from outside"):
        pneumatic_robot(solid, surfaces=[everything], chambers=[{**PLACE, "surface": "skin"}])


def test_a_mesh_without_a_cavity_says_so(tmp_path: Path) -> None:
    with pytest.raises(RobotFileError, match="lies in none of the 0 cavities of the mesh"):
        pneumatic_robot(box_mesh(HOLLOW_SIZE, (5, 2, 2)))


def test_an_stl_in_another_unit_is_refused(tmp_path: Path) -> None:
    mesh = hollow_beam()
    triangles = pneumatic_robot(mesh).actuator_set.chambers.nodes
    file = tmp_path / "cavity.stl"
    meshio.write_points_cells(file, 1e3 * mesh.nodes, [("triangle", triangles)])
    with pytest.raises(RobotFileError, match="check its unit"):
        built(chambers=[{**PLACE, "stl": str(file)}])


def test_the_order_of_actuators_is_that_of_the_tables() -> None:
    drum = {**DRUM, "members": ["upper", "tendon"], "gains": [1.0, -1.0], "pretensions": [2, 2]}
    robot = built(
        cables=[{**CABLE, "name": "first"}, CABLE, {**CABLE, "name": "upper"}],
        forces=[PUSH],
        couplings=[drum],
    )
    assert robot.actuators.names == ("first", "drum", "bellows", "push")
    assert robot.actuators.laws.bilateral.tolist() == [False, True, True, True]
    assert robot.actuators.laws.held_by_force.tolist() == [False, False, True, True]
    assert robot.actuators.groups.tolist() == [0, 0, 1, 2]
