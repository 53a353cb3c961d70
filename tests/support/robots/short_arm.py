"""An arm of three vertebrae with six ribs each, three tendons and contacts: beams for short campaigns."""

from __future__ import annotations

import json
from pathlib import Path

from benchmarks.robots.arm import ArmShape, make_network
from benchmarks.robots.make_manipulator import make_file
from tauten.model import Robot, load_robot
from tauten.model.beams import BeamBody

SHAPE = ArmShape(length=0.16, sections=1, joints=3)
CANDIDATES = 90


COUPLING = """
[[couplings]]                # tendons a and b on one motor, with a pretension
name = "pair"
members = ["tendon1a", "tendon1b"]
gains = [1.0, -0.5]
pretensions = [20.0, 10.0]
max_position = 0.03
max_effort = 15.0
max_rate = 0.1
"""


def write_short_arm(folder: Path, more: str = "") -> Path:
    """Robot file without a basis, with more tables, and its beams in a folder; returns the file."""
    (folder / "manipulator.json").write_text(json.dumps(make_network(SHAPE)))
    text = make_file(SHAPE, "short_arm", CANDIDATES).replace('basis = "short_arm"\n', "")
    file = folder / "short_arm.toml"
    file.write_text(text + more)
    return file


def short_arm(folder: Path, more: str = "") -> Robot[BeamBody]:
    """The robot, with more tables in its file."""
    robot = load_robot(write_short_arm(folder, more))
    assert isinstance(robot.body, BeamBody)
    return robot
