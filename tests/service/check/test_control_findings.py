"""`tauten check`: whether the controller decides from the robot's start, and within its period."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

import pytest
from support.robots.examples import EXAMPLES, example
from support.robots.hanging import hanging_beam

from tauten.model import load_robot
from tauten.model.load import robot_path
from tauten.service.check import CheckSettings, Finding, check_robot, faster
from tauten.service.check.control_findings import step_time
from tauten.service.check.rate import reducing
from tauten.service.process import StopFlag


def findings(folder: Path, **changes: Any) -> dict[str, Finding]:
    """What is found about a beam that hangs at its cable, by subject."""
    path = hanging_beam(folder, **changes)
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
    file = tmp_path / "beam.toml"
    reduced = step_time(0.03, 0.02, file, reduced=True)
    assert reduced.advice == "set controller.rate = 26, or reduce with fewer modes"
    push = load_robot(example("11_push")["FILE"])
    pushing = step_time(0.03, 0.02, file, reduced=True, robot=push)
    assert "controller.rate = 26 and every max_rate lower by the same factor" in pushing.advice


def test_of_a_robot_of_parts_the_parts_are_reduced(tmp_path: Path) -> None:
    """`tauten reduce` refuses the file of all parts, and that of an object, which has no actuator."""
    pair = tmp_path / "pair.toml"
    (tmp_path / "one.toml").write_text('[[cables]]\nname = "pull"\n')
    (tmp_path / "cube.toml").write_text("[[bodies]]\nfree = true\n")
    files = {"left": "one", "right": "one", "held": "cube"}
    parts = [f'[[parts]]\nname = "{name}"\nrobot = "{file}.toml"\n' for name, file in files.items()]
    pair.write_text("\n".join(('name = "pair"', *parts)))
    assert reducing(pair) == f"tauten reduce {tmp_path / 'one.toml'} --states --write"


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


def test_contacts_that_decisions_do_not_know_are_said(tmp_path: Path) -> None:
    """A robot file got contacts and nothing else, and the node touched what it did not know."""
    touching = '[[contacts]]\nagainst = "itself"\npoints = 20\n'
    found = findings(tmp_path, more=touching)["contacts in decisions"]
    assert found.level == "doubtful"
    assert 'controller.basis = "full"' in found.advice
    left_out = findings(tmp_path, more=f'basis = "none"\n{touching}')
    assert "contacts in decisions" not in left_out


def test_a_shipped_robot_is_not_told_to_change_its_file() -> None:
    """`tauten reduce manipulator --states --write` and another rate in its file were advised."""
    assert reducing(robot_path("manipulator")) == "--model reduced"
    assert "with a copy" in reducing(robot_path("manipulator_1290"))
    assert reducing(EXAMPLES / "hand.toml") == "--model reduced"
    slow = [step_time(0.03, 0.02, robot_path("manipulator"), reduced) for reduced in (False, True)]
    assert [one.advice for one in slow] == [
        "--model reduced gives a model with faster steps; or serve it with --rate 26",
        "serve it with --rate 26",
    ]


def test_a_shipped_robot_that_vibrates_fast_is_told_another_rate() -> None:
    """`controller.rate` and `controller.substeps` of its file were advised."""
    nothing = CheckSettings("tripod", ())
    result = check_robot(nothing, StopFlag(), lambda _share, _what="": None)
    found = {item.subject: item.advice for item in result.findings}
    assert re.search(r"tauten serve --rate 216 would resolve it$", found["natural frequencies"])
    assert not [advice for advice in found.values() if "controller." in advice]


@pytest.mark.parametrize(("seconds", "level"), [(0.015, "fine"), (0.0161, "doubtful")])
def test_a_fifth_of_the_period_is_left_for_the_rest(seconds: float, level: str) -> None:
    assert step_time(seconds, 0.02, robot_path("finger"), reduced=False).level == level


@pytest.mark.long
@pytest.mark.parametrize(("load", "said"), [(1.0, False), (6.5, True)])
def test_a_busy_computer_is_said_where_the_robot_file_is_to_be_changed(
    load: float, said: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The demo of a clone told a first user to reduce the shipped finger because other programs ran."""
    monkeypatch.setattr(os, "getloadavg", lambda: (load, load, load))
    monkeypatch.setattr(os, "sched_getaffinity", lambda _process: {0, 1})
    robot = load_robot("finger")
    advice = faster(robot_path("finger"), 0.019, True, robot, here=True)
    assert advice.startswith("serve it with --rate 42")
    assert ("; this computer is busy (load 6.5 on 2 processors), on an idle one" in advice) == said
