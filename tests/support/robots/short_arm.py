"""An arm of three vertebrae with six ribs each, three tendons and contacts: beams for short campaigns."""

from __future__ import annotations

import json
from pathlib import Path

from tauten.model import load_robot
from tauten.model.beams import BeamRobot
from tauten.model.robots.arm import ArmShape, make_structure
from tauten.model.robots.make_manipulator import make_file

SHAPE = ArmShape(length=0.16, sections=1, joints=3)
CANDIDATES = 90


def write_short_arm(folder: Path) -> Path:
    """Robot file and structure in a folder; returns the file. It has no contact basis yet."""
    (folder / "manipulator.json").write_text(json.dumps(make_structure(SHAPE)))
    text = make_file(SHAPE, "short_arm", CANDIDATES).replace('basis = "short_arm"\n', "")
    file = folder / "short_arm.toml"
    file.write_text(text)
    return file


def short_arm(folder: Path) -> BeamRobot:
    """The robot."""
    robot = load_robot(write_short_arm(folder))
    assert isinstance(robot, BeamRobot)
    return robot
