"""What has to work with every version of Python and libraries; `.ci/versions` runs it with several of them.

Beside these, the shipped bases are loaded there (`tests/reduction/test_shipped.py`), every library for QPs is
compared (`tests/controller/qpcc/test_qp.py`), hostile messages are decoded or refused
(`tests/service/wire/test_fuzz_messages.py`), and a served robot is found (`tests/e2e/test_cli.py`).
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from support.processes import run_main
from support.robots.bodies import HOLLOW_SIZE, pneumatic_robot

from tauten.controller import Controller
from tauten.model import Robot, Simulator
from tauten.model.kernels import seed_file
from tauten.service.kernels import take_inventory
from tauten.service.wire import CDR, Joints, decode_joints, encode_joints

pytestmark = pytest.mark.versions


def test_commands_show_help_and_schema(capsys: pytest.CaptureFixture[str]) -> None:
    assert run_main("--help") == 0
    assert run_main("reduce", "--help") == 0
    assert "--design" in capsys.readouterr().out
    assert run_main("schema") == 0
    assert "RobotFile" in json.loads(capsys.readouterr().out)["$defs"]


def test_kernels_that_are_shipped_for_this_python_are_those_of_the_sources() -> None:
    """The file for each Python is packed by itself; what has changed since then, every user compiles."""
    file = seed_file()
    if file is None or not file.is_file():
        pytest.skip("no kernels are shipped for this Python, numba and system")
    assert take_inventory().changed <= 5


def test_a_command_reads_a_shipped_basis(capsys: pytest.CaptureFixture[str]) -> None:
    assert run_main("inspect", "finger") == 0
    assert "snapshots" in capsys.readouterr().out


def test_a_robot_file_that_is_wrong_is_one_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "wrong.toml"
    file.write_text('name = "wrong"\nstrange = 1\n')
    assert run_main("compare", file) == 2
    assert "strange" in capsys.readouterr().err


def test_the_controller_reaches_a_target(beam: Robot) -> None:
    controller = Controller(beam)
    start = beam.effector(beam.rest())
    goal = start + np.array([[0.0, 0.0, 0.002], [0.0, 0.0, 0.0007]])
    for _ in range(60):
        controller.step(goal)
    off = np.linalg.norm(beam.effector(controller.state) - start, axis=1)
    assert off[0] > 1e-3


def test_a_pressurised_body_bends_towards_its_thick_side() -> None:
    simulator = Simulator(pneumatic_robot())
    assert simulator.settle(effort=[2e4]).converged
    moved = simulator.effector - simulator.robot.effector(simulator.robot.rest())
    assert np.abs(moved).max() > 1e-3 * HOLLOW_SIZE[0]


def test_messages_come_back_as_they_were_sent() -> None:
    sent = Joints(7, "base", ("a", "b"), (0.1, 0.2), (3.0, 4.0))
    assert decode_joints(encode_joints(sent), CDR, ("a", "b")) == sent
