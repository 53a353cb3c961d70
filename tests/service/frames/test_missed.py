"""Targets out of reach are told from those that the robot is on its way to, and from a wrong model."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.robots.thumb import write_thumb
from support.viewers import wait_until

from tauten.model import NO_CONTACTS, Geometry
from tauten.model.numerics import Array
from tauten.service.describing import describe
from tauten.service.frames import ReachSearch, RobotLook, ViewFrame, missed
from tauten.service.setup import load_setup
from tauten.service.wire import Cause, Mode

NOTHING = np.zeros((0, 3), np.float32)


@pytest.fixture(scope="module")
def look(beam_file: Path) -> RobotLook:
    """What a viewer knows of the small robot."""
    return RobotLook(describe(load_setup(beam_file)), NOTHING)


def frame_at(
    time: float, goal: Array, values: Array, mode: Mode = Mode.RUN, modelled: Array | None = None
) -> ViewFrame:
    """A frame of an effector."""
    return ViewFrame(
        time, mode, Cause.NONE, "OK", Geometry(NOTHING, NOTHING.reshape(0, 2, 3), NO_CONTACTS),
        np.zeros(1), np.zeros(1), goal, values, 0.01, None, modelled,
    )  # fmt: skip


def test_a_robot_at_rest_away_from_its_target_misses_it(look: RobotLook) -> None:
    rest = look.robot.rest
    x = np.eye(len(rest))[0]
    goal = rest + 0.03 * x
    times = np.linspace(0.0, 1.0, 11)
    still = [frame_at(time, goal, rest) for time in times]
    miss = missed(look, still)
    assert miss is not None
    assert miss.distance == pytest.approx(0.03)
    assert miss.nearest == pytest.approx(rest[:3])
    assert missed(look, still[:4]) is None, "too early to say"
    moving = [frame_at(time, goal, rest + 0.01 * time * x) for time in times]
    assert missed(look, moving) is None
    dragged = [frame_at(time, goal + 0.01 * time * x, rest) for time in times]
    assert missed(look, dragged) is None
    held = [frame_at(time, goal, rest, Mode.HOLD) for time in times]
    assert missed(look, held) is None
    near = [frame_at(time, rest + 1e-4, rest) for time in times]
    assert missed(look, near) is None
    wrong = [frame_at(time, goal, rest, modelled=goal) for time in times]
    assert missed(look, wrong) is None, "the model is there: the robot differs from it"


@pytest.mark.long
def test_the_reach_of_one_cable_is_a_curve_from_rest(tmp_path: Path) -> None:
    search = ReachSearch(str(write_thumb(tmp_path)))
    try:
        assert len(search.of(0).points) == 0, "nobody waits for it"
        assert wait_until(lambda: search.of(0).complete, 180.0)
        found = search.of(0)
    finally:
        search.close()
    assert found.is_curve
    assert len(found.points) == found.wanted
    assert found.points[0] == pytest.approx([0.0075, 0.0075, -0.05], abs=1e-4)
    steps = np.linalg.norm(np.diff(found.points, axis=0), axis=1)
    assert steps.sum() > 0.015, "it bends by a third of its length"
    assert steps.max() < 0.001
