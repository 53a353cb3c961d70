"""A gripper that is told only where a cube is to go: it closes, squeezes and lifts."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from tauten.controller import Controller
from tauten.controller.qpcc import Status
from tauten.model import load_robot

EXAMPLES = Path(__file__).resolve().parents[3] / "examples"
PLACE = """
[[effectors]]
name = "place"
kind = "centre"
region = { lower = [-1.0, -1.0, -1.0], upper = [1.0, 1.0, 1.0] }
"""


@pytest.mark.slow
def test_a_target_of_the_cube_alone_makes_the_gripper_lift_it(tmp_path: Path) -> None:
    for name in ("cube.vtu", "fork.vtu", "grasp.toml"):
        shutil.copy(EXAMPLES / name, tmp_path)
    (tmp_path / "cube.toml").write_text((EXAMPLES / "cube.toml").read_text() + PLACE)
    fork = (EXAMPLES / "fork.toml").read_text()
    own = fork[fork.index("[[effectors]]") : fork.index("[[surfaces]]")]
    (tmp_path / "fork.toml").write_text(fork.replace(own, ""))
    controller = Controller(load_robot(tmp_path / "grasp.toml"))
    start, axis = controller.effector_values, np.array([0.0, 0.0, 0.012])
    statuses = set()
    for step in range(45):
        angle = 0.4 * min(max(0.02 * step - 0.04, 0.0), 0.5)
        turn = np.array(
            [[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]]
        )
        goal = axis + turn @ (start - axis)
        statuses.add(controller.step(goal).status)
    assert Status.SEEKING_CONTACT in statuses
    assert (controller.effector_values - start)[2] > 0.015  # m, off the floor
    assert np.abs(controller.effector_values - goal).max() < 1e-3
