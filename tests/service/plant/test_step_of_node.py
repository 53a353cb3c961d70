"""The demo asks its node how long a control step takes until it says so."""

from __future__ import annotations

import math
from contextlib import nullcontext

import pytest
from support.robots.examples import shipped_setup

from tauten.service.plant import demo
from tauten.service.process import StopFlag
from tauten.service.wire import Keys, Network


@pytest.mark.parametrize("silent", [0, 3])
def test_a_node_is_asked_until_it_answers(monkeypatch: pytest.MonkeyPatch, silent: int) -> None:
    answers = iter([math.nan] * silent + [0.03, 0.04])
    monkeypatch.setattr(demo, "session_of", lambda *_: nullcontext())
    monkeypatch.setattr(demo, "is_alive", lambda *_: True)
    monkeypatch.setattr(demo, "step_at_start", lambda *_: next(answers))
    assert demo._wait_alive(Keys("arm"), Network(1), (), StopFlag()) == 0.03


def test_a_robot_that_may_touch_something_needs_time_for_longer_steps() -> None:
    """Steps of the manipulator take 1.7 times as long where its ribs push as at the start."""
    assert demo.step_in_demo(0.012, shipped_setup("manipulator_1290").robot) >= 1.7 * 0.012
    assert demo.step_in_demo(0.012, shipped_setup("trunk").robot) == 0.012
