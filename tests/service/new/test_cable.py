"""A cable that is added to a robot file: nothing else of the file changes, nothing wrong is written."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.processes import ROBOT, write_robot

from tauten.model import RobotFileError, load_robot
from tauten.service.new import NewCable, add_cable

POINTS = np.array([[0.0, 0.02, 0.01], [0.02, 0.02, 0.01], [0.09, 0.02, 0.0101234]])


def test_comments_and_all_other_text_remain(tmp_path: Path) -> None:
    text = "# a comment\n" + ROBOT + "\n# the last line"
    file = write_robot(tmp_path, text)
    add_cable(file, NewCable("side", POINTS, 20.0, 1e-3))
    assert file.read_text(encoding="utf-8").startswith(text + "\n")
    robot = load_robot(file)
    assert robot.actuators.names == ("lower", "upper", "side")
    assert robot.limits.effort_max[2] == 20.0
    ends = robot.actuator_segments(robot.rest())[robot.actuator_set.segment_owners == 2]
    assert ends[0, 0] == pytest.approx(POINTS[0])
    assert ends[:, 1] == pytest.approx(POINTS[1:], abs=1e-5)
    assert sorted(one.name for one in tmp_path.iterdir()) == ["beam.toml", "beam.vtu"]


@pytest.mark.parametrize(
    ("name", "points", "match"),
    [
        ("lower", POINTS, r"beam.toml: .*'lower' is used twice"),
        ("side", POINTS[:1], r"beam.toml: cable 'side' needs two points"),
        ("side", POINTS + 1.0, r"beam.toml: .*outside the mesh"),
        ("si\nde", POINTS, r"beam.toml"),
    ],
)
def test_what_is_no_robot_is_not_written(
    name: str, points: np.ndarray, match: str, tmp_path: Path
) -> None:
    file = write_robot(tmp_path)
    with pytest.raises(RobotFileError, match=match):
        add_cable(file, NewCable(name, points, 20.0, 1e-3))
    assert file.read_text(encoding="utf-8") == ROBOT
    assert sorted(one.name for one in tmp_path.iterdir()) == ["beam.toml", "beam.vtu"]


def test_a_file_that_lists_its_cables_in_one_line_is_not_changed(tmp_path: Path) -> None:
    head = ROBOT.partition("[[cables]]")[0]
    inline = (
        'cables = [{ name = "a", points = [[0.01, 0.01, 0.002], [0.1, 0.01, 0.002]], max_tension = 30.0, '
        "max_pull = 0.02, max_rate = 0.05 }]\n"
    )
    text = head + inline + '\n[[effectors]]\nname = "tip"\npoint = [0.1, 0.01, 0.01]\n'
    file = write_robot(tmp_path, text)
    load_robot(file)
    with pytest.raises(RobotFileError, match=r"beam.toml"):
        add_cable(file, NewCable("side", POINTS, 20.0, 1e-3))
    assert file.read_text(encoding="utf-8") == text
