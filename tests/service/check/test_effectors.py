"""`tauten check` on effectors of every kind."""

from __future__ import annotations

from pathlib import Path

from support.processes import ROBOT, write_robot

from tauten.service.check import CheckSettings, check_robot
from tauten.service.process import StopFlag

EFFECTORS = """\
[[effectors]]
name = "tool"
kind = "frame"
region = { lower = [0.099, -1.0, -1.0], upper = [1.0, 1.0, 1.0] }
point = [0.15, 0.01, 0.01]

[[effectors]]
name = "span"
kind = "distance"
point = [0.1, 0.01, 0.018]
other = [0.05, 0.01, 0.018]
"""


def test_a_frame_may_have_its_origin_outside_and_distances_their_points(tmp_path: Path) -> None:
    robot = write_robot(tmp_path, ROBOT.split("[[effectors]]", maxsplit=1)[0] + EFFECTORS)
    settings = CheckSettings(str(robot), shares=())
    checked = check_robot(settings, StopFlag(), lambda _share, _what: None)
    found = {finding.subject: finding for finding in checked.findings}
    assert not checked.refused
    assert found["cables and effectors"].level == "fine"
    assert "all 6 points" in found["cables and effectors"].found
    assert found["region effectors.0.region"].found.startswith("4 nodes")
