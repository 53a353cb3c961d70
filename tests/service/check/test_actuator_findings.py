"""`tauten check` of what actuators can do: mistakes with which a robot loads, and does not move as meant."""

from __future__ import annotations

import re
from pathlib import Path

import meshio
import pytest
from support.robots.bodies import box_mesh

from tauten.model import load_robot
from tauten.model.schema import RobotConfig, read_toml, validated
from tauten.service.check import Finding
from tauten.service.check.actuator_findings import actuator_findings, movements
from tauten.service.check.body_findings import mass
from tauten.service.check.robot_check import least_density

BEAM = """
name = "beam"
gravity = [0.0, 0.0, -9.81]
[[bodies]]
name = "one"
mesh = { file = "beam.vtu", element = "smoothed" }
[[bodies]]
name = "other"
mesh = { file = "beam.vtu", element = "smoothed" }
position = [0.05, 0.0, 0.0]
[material]
young_modulus = 3e5
poisson_ratio = 0.45
density = 1070
[[fixed]]
lower = [-1, -1, 0.099]
upper = [1, 1, 0.101]
[[cables]]
name = "left"
pull_point = [0.002, 0.01, 0.1]
points = [[0.002, 0.01, 0.08], [0.002, 0.01, 0.002]]
max_pull = 0.02
max_tension = 10
max_rate = 0.02
[[cables]]
name = "right"
pull_point = [0.018, 0.01, 0.1]
points = [[0.018, 0.01, 0.08], [0.018, 0.01, 0.002]]
max_pull = 0.02
max_tension = 10
max_rate = 0.02
[[effectors]]
name = "tip"
point = [0.01, 0.01, 0.0]
"""
SIDE, LENGTH = 0.02, 0.1  # m


def found(folder: Path, text: str) -> dict[str, Finding]:
    """The findings of a robot file of two beams beside each other, by their subjects."""
    mesh = box_mesh((SIDE, SIDE, LENGTH), (2, 2, 10))
    meshio.Mesh(mesh.nodes, [("tetra", mesh.tets)]).write(folder / "beam.vtu")
    file = folder / "beam.toml"
    file.write_text(text, encoding="utf-8")
    config, robot = validated(RobotConfig, read_toml(file), file), load_robot(file)
    findings = [*actuator_findings(robot, config), mass(robot, least_density(config))]
    return {one.subject: one for one in findings}


def test_a_sound_robot_is_fine_and_moves_as_far_as_its_cables_take_it(tmp_path: Path) -> None:
    findings = found(tmp_path, BEAM)
    assert [one.level for one in findings.values()] == ["fine"] * 4
    assert findings["cables against their pulls"].found == "the largest pull is 20.4 % of the cable"
    assert findings["rates of actuators"].found == "from rest to the farthest position in 1 s"
    moved, _, _ = movements(load_robot(tmp_path / "beam.toml"))
    # a tension T at e from the axis: θ = T e L / E I, and the pull is T L / E A + e θ
    e, pull = 0.008, 0.002
    bent = e * pull / (e**2 + SIDE**2 / 12.0) * LENGTH / 2.0
    assert moved[:, 0] == pytest.approx([bent] * 2, rel=0.2)


@pytest.mark.long
@pytest.mark.parametrize(
    ("old", "new", "subject", "level", "said"),
    [
        ("[0.01, 0.01, 0.0]", "[0.01, 0.01, 0.1]", "movement of effectors", "wrong",
         "no actuator moves tip by more than"),
        ("0.018,", "0.068,", "movement of effectors", "doubtful",
         "right moves no effector by more than"),
        ("3e5", "3e11", "movement of effectors", "doubtful", " needs .* way, allowed are 10 N"),
        ("max_pull = 0.02", "max_pull = 0.11", "cables against their pulls", "wrong",
         "left is 98 mm long and pulled by 110 mm"),
        ("[0.002, 0.01, 0.1]", "[2, 10, 100]", "cables against their pulls", "doubtful",
         "left starts 100 m from its first point"),
        ("max_rate = 0.02", "max_rate = 20", "rates of actuators", "doubtful", "left gets .* in 0.001 s"),
        ("max_rate = 0.02", "max_rate = 2e-5", "rates of actuators", "doubtful", "left gets .* in 1e.03 s"),
        ("1070", "1.07", "moving mass", "doubtful", "with a density of 1.07 kg/m³"),
    ],
)  # fmt: skip
def test_mistakes_with_which_a_robot_loads_are_said(
    old: str, new: str, subject: str, level: str, said: str, tmp_path: Path
) -> None:
    assert old in BEAM
    text = BEAM.replace(old, new) if "right" in said else BEAM.replace(old, new, 1)
    finding = found(tmp_path, text)[subject]
    assert finding.level == level and finding.advice
    assert re.search(said, finding.found), finding.found


ROD = """
name = "rod"
[material]
young_modulus = 60e9
poisson_ratio = 0.3
density = 6450
[[profiles]]
kind = "tube"
name = "wire"
outer = 1e-3
[[bodies]]
name = "wire"
beam = { points = [[0.0, 0.0, 0.0], [0.0, 0.0, -0.2]], elements = 4, profile = "wire" }
fixed = [{ kind = "sphere", centre = [0.0, 0.0, 0.0], radius = 1e-6 }]
[[cables]]
name = "left"
points = [[-0.01, 0.0, 0.0], [-0.01, 0.0, -0.05], [-0.01, 0.0, -0.1], [-0.01, 0.0, -0.15], [-0.01, 0.0, -0.2]]
max_outside = 0.011
max_tension = 5.0
max_pull = 0.02
max_rate = 0.02
[[cables]]
name = "right"
points = [[0.01, 0.0, 0.0], [0.01, 0.0, -0.05], [0.01, 0.0, -0.1], [0.01, 0.0, -0.15], [0.01, 0.0, -0.2]]
max_outside = 0.011
max_tension = 5.0
max_pull = 0.02
max_rate = 0.02
[[effectors]]
name = "tip"
point = [0.0, 0.0, -0.2]
"""


@pytest.mark.long
def test_cables_that_let_nothing_out_hold_a_rod_back(tmp_path: Path) -> None:
    """A rod does not shorten: what one cable is pulled by, the other one has to let out.

    Decisions led nowhere with status OK, and the check said that each cable moves the tip.
    """
    file = tmp_path / "rod.toml"
    for text, level in (
        (ROD, "doubtful"),
        (ROD.replace("max_pull", "min_pull = -0.03\nmax_pull"), "fine"),
    ):
        file.write_text(text, encoding="utf-8")
        config, robot = validated(RobotConfig, read_toml(file), file), load_robot(file)
        finding = {one.subject: one for one in actuator_findings(robot, config)}[
            "movement of effectors"
        ]
        assert finding.level == level, finding
        if level == "doubtful":
            taken = float(re.search(r"takes ([0-9.]+) mm more of", finding.found).group(1))  # type: ignore[union-attr]
            assert taken == pytest.approx(2.0, rel=0.1), "a tenth of 20 mm"
            assert "min_pull of left, right" in finding.advice
