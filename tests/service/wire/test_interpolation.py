"""Targets on straight lines between messages: numbers linearly, rotations evenly about one axis."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp
from support.messages import point_layout
from support.processes import ROBOT, run_main, write_robot

from tauten.model import EffectorLayout, RobotFileError
from tauten.service.setup import load_setup
from tauten.service.wire.interpolation import TargetCourse

LAYOUT = point_layout(["tip", "middle"])
HERE = np.array([0.0, 0.0, -0.1, 0.0, 0.1, 0.0])
EFFECTORS = """\
[[effectors]]
name = "tool"
kind = "frame"
region = { lower = [0.099, -1.0, -1.0], upper = [1.0, 1.0, 1.0] }

[[effectors]]
name = "span"
kind = "distance"
point = [0.1, 0.01, 0.018]
other = [0.05, 0.01, 0.018]
"""


def tip(course: TargetCourse, now: float) -> float:
    """The first value of a course whose first effector alone has targets."""
    return float(course.at(now, HERE, (True, False))[0])


def test_the_goal_is_on_the_line_between_two_targets_so_much_later() -> None:
    course = TargetCourse(LAYOUT, 0.1, 0.5)
    course.add(0, 1.0, (0.0, 0.0, 0.0))
    course.add(0, 1.08, (0.08, 0.0, 0.0))
    course.add(0, 1.2, (0.08, 0.0, 0.0))
    found = [tip(course, now) for now in (1.0, 1.1, 1.12, 1.16, 1.18, 1.25, 1.3, 1.4)]
    np.testing.assert_allclose(found, [0.0, 0.0, 0.02, 0.06, 0.08, 0.08, 0.08, 0.08], atol=1e-12)
    # effectors that are not followed are where they are
    np.testing.assert_array_equal(course.at(1.4, HERE, (True, False))[3:], HERE[3:])


def test_each_effector_has_a_line_of_its_own() -> None:
    course = TargetCourse(LAYOUT, 0.1, 0.5)
    course.add(0, 1.0, (0.0, 0.0, 0.0))
    course.add(1, 1.02, (0.2, 0.0, 0.0))
    course.add(0, 1.1, (0.1, 0.0, 0.0))
    course.add(1, 1.12, (0.1, 0.0, 0.0))
    found = course.at(1.15, HERE, (True, True))
    np.testing.assert_allclose(found[[0, 3]], [0.05, 0.17], atol=1e-12)


def test_there_is_no_line_across_a_pause() -> None:
    """A stream that begins again jumps to its first target, as without interpolation."""
    course = TargetCourse(LAYOUT, 0.1, 0.5)
    course.add(0, 1.0, (0.0, 0.0, 0.0))
    course.add(0, 1.6, (0.06, 0.0, 0.0))
    assert tip(course, 1.6) == 0.06
    assert tip(course, 1.65) == 0.06


def test_a_target_replaces_those_that_were_not_made_before_it() -> None:
    course = TargetCourse(LAYOUT, 0.1, 0.5)
    for made, x in ((1.0, 0.0), (1.2, 0.2), (1.1, 0.05)):  # the last one was said last
        course.add(0, made, (x, 0.0, 0.0))
    assert tip(course, 1.15) == pytest.approx(0.025)
    assert tip(course, 1.25) == 0.05
    course.add(0, 1.1, (0.07, 0.0, 0.0))
    assert tip(course, 1.25) == 0.07


def test_poses_turn_evenly_about_one_axis(pose_layout: EffectorLayout) -> None:
    turns = Rotation.from_rotvec([[0.1, 0.0, 0.0], [0.3, -0.9, 0.5]])
    ends = [np.roll(turn.as_quat(), 1) for turn in turns]  # w first
    ends[1] = -ends[1]  # the same rotation
    course = TargetCourse(pose_layout, 0.2, 0.5)
    for made, x, q in zip((1.0, 1.1), (0.0, 0.1), ends, strict=True):
        course.add(0, made, (x, 0.0, 0.0, *q.tolist()))
        course.add(1, made, (0.02 + 0.1 * x,))
    here = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.01])
    between = Slerp([1.0, 1.1], turns)
    for time in np.linspace(1.0, 1.1, 7):
        found = course.at(time + 0.2, here, (True, True))
        assert found[0] == pytest.approx(time - 1.0, abs=1e-12)
        assert found[7] == pytest.approx(0.02 + 0.1 * (time - 1.0), abs=1e-12)
        off = Rotation.from_quat(np.roll(found[3:7], -1)) * between(time).inv()
        assert off.magnitude() < 1e-9
        assert np.linalg.norm(found[3:7]) == pytest.approx(1.0)


def test_a_flood_of_targets_does_not_fill_the_memory() -> None:
    course = TargetCourse(LAYOUT, 0.4, 0.5)
    for index in range(20_000):
        course.add(0, 1.0 + 1e-5 * index, (1e-6 * index, 0.0, 0.0))
    assert sum(len(knots) for knots in course._knots) <= 4096
    assert tip(course, 1.6) == pytest.approx(0.019_999)


@pytest.fixture
def pose_layout(tmp_path: Path) -> EffectorLayout:
    """A frame and a distance."""
    text = ROBOT.split("[[effectors]]", maxsplit=1)[0] + EFFECTORS
    return load_setup(write_robot(tmp_path, text)).robot.effector_layout


@pytest.mark.parametrize("delay", [0.0, 0.29])
def test_a_robot_file_has_a_delay_shorter_than_its_timeout(tmp_path: Path, delay: float) -> None:
    text = ROBOT.replace("target_timeout", f"interpolation_delay = {delay}, target_timeout")
    assert load_setup(write_robot(tmp_path, text)).service.interpolation_delay == delay


@pytest.mark.parametrize("delay", ["0.3", "1.0", "-0.1", "nan", '"a"'])
def test_delays_that_are_not_allowed(tmp_path: Path, delay: str) -> None:
    text = ROBOT.replace("target_timeout", f"interpolation_delay = {delay}, target_timeout")
    with pytest.raises(RobotFileError, match=r"service.interpolation_delay: [^\n]{10,}"):
        load_setup(write_robot(tmp_path, text))


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--interpolate", "0.3"), "shorter than target_timeout, 0.3 s"),
        (("--interpolate", "-1"), "--interpolate"),
        (("--interpolate", "0.1", "--event"), "--event"),
    ],
)
def test_an_option_that_is_not_allowed_ends_in_a_sentence(
    tmp_path: Path, options: tuple[str, ...], says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run_main("serve", write_robot(tmp_path), *options) == 2
    assert says in " ".join(capsys.readouterr().err.replace("│", " ").split())
