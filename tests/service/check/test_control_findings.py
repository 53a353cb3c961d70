"""`tauten check`: whether the controller decides from the robot's start, and within its period."""

from __future__ import annotations

from pathlib import Path

import meshio
import pytest
from support.robots.bodies import box_mesh

from tauten.service.check import CheckSettings, Finding, check_robot
from tauten.service.check.control_findings import step_time
from tauten.service.process import StopFlag

BEAM = """
name = "beam"
gravity = [0.0, 0.0, -9.81]
[mesh]
file = "beam.vtu"
[material]
young_modulus = {young}
poisson_ratio = 0.3
density = 1000.0
[[fixed]]
lower = [0.0, 0.0, 0.0]
upper = [0.0, 0.02, 0.02]
[[cables]]
name = "tendon"
pull_point = [0.18, 0.01, 0.1]
points = [[0.18, 0.01, 0.01]]
max_tension = {tension}
max_pull = 0.05
max_rate = 0.1
[[effectors]]
name = "tip"
point = [0.2, 0.01, 0.01]
[controller]
rate = {rate}
"""


def findings(
    folder: Path, tension: float = 100.0, rate: float = 20.0, young: float = 1e6, more: str = ""
) -> dict[str, Finding]:
    """What is found about a beam that hangs at its cable, by subject."""
    mesh = box_mesh((0.2, 0.02, 0.02), (10, 1, 1))
    meshio.write(folder / "beam.vtu", meshio.Mesh(mesh.nodes, [("tetra", mesh.tets)]))
    path = folder / "beam.toml"
    path.write_text(BEAM.format(tension=tension, rate=rate, young=young) + more, encoding="utf-8")
    result = check_robot(CheckSettings(str(path), ()), StopFlag(), lambda _share, _what="": None)
    return {item.subject: item for item in result.findings}


def test_a_robot_that_decides_in_time_is_fine(tmp_path: Path) -> None:
    found = findings(tmp_path)
    assert found["first decision"].level == "fine"
    assert found["first decision"].found == "10 decisions from the start: OK 10"
    step = found["control step against period"]
    assert step.level == "fine"
    assert "of 50 ms" in step.found


def test_a_period_that_is_too_short_is_doubtful_and_says_what_to_do(tmp_path: Path) -> None:
    step = findings(tmp_path, rate=9000.0)["control step against period"]
    assert step.level == "doubtful"
    assert f"tauten reduce {tmp_path / 'beam.toml'} --states" in step.advice
    assert "controller.rate = " in step.advice
    reduced = step_time(0.03, 0.02, "finger", reduced=True)
    assert reduced.advice == "set controller.rate = 27, or reduce with fewer modes"


def test_a_robot_that_no_cable_of_its_strength_holds_is_wrong(tmp_path: Path) -> None:
    found = findings(tmp_path, tension=1e-4, young=3e3)["first decision"]
    assert found.level == "wrong"
    assert found.found == "10 decisions from the start: RELAXED 10"
    assert "limits cannot all be met in this step" in found.advice
    assert "tendon" in found.advice


def test_a_basis_that_is_missing_is_said(tmp_path: Path) -> None:
    found = findings(tmp_path, more='basis = "missing.basis"\n')["first decision"]
    assert found.level == "wrong"
    assert "missing.basis" in found.found


@pytest.mark.parametrize(("seconds", "level"), [(0.015, "fine"), (0.0161, "doubtful")])
def test_a_fifth_of_the_period_is_left_for_the_rest(seconds: float, level: str) -> None:
    assert step_time(seconds, 0.02, "finger", reduced=False).level == level
