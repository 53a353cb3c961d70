"""Integral action on top of the model: it removes a constant mismatch and does not wind up."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tauten.service.node import Feedback

H = 0.02
OFF = np.array([[0.003, 0.0, -0.002]])  # the robot is that far from its model


def follow(feedback: Feedback, target: np.ndarray, reach: float, steps: int) -> np.ndarray:
    """A model that reaches goals within a ball at once, a robot that is off; where the robot ends."""
    measured = OFF * 0.0
    for _ in range(steps):
        goal = target + feedback.correction
        model = goal * min(1.0, reach / float(np.linalg.norm(goal)))
        measured = model - OFF
        feedback.observe(model, measured, H)
    return measured


def test_a_mismatch_is_removed_at_the_gains_pace() -> None:
    feedback, target = Feedback(1, gain=2.0, largest=1.0), np.array([[0.01, 0.02, 0.0]])
    error = [float(np.linalg.norm(follow(feedback, target, 1.0, 25) - target)) for _ in range(6)]
    # half a second a turn: the error falls by e each
    np.testing.assert_allclose(np.array(error[1:]) / error[:-1], np.exp(-1.0), rtol=1e-9)
    np.testing.assert_allclose(feedback.correction, OFF, rtol=0.01)


def test_a_target_out_of_reach_does_not_wind_it_up() -> None:
    feedback, far = Feedback(1, gain=2.0, largest=10.0), np.array([[0.3, 0.0, 0.0]])
    follow(feedback, far, reach=0.1, steps=5000)
    assert np.linalg.norm(feedback.correction) <= np.linalg.norm(OFF) * (1.0 + 1e-9)
    # so back in reach it is right at once
    near = np.array([[0.05, 0.0, 0.0]])
    np.testing.assert_allclose(follow(feedback, near, 0.1, 2), near, atol=1e-6)


@given(st.lists(st.tuples(st.floats(-1.0, 1.0), st.floats(0.0, 10.0)), max_size=30))
def test_no_correction_is_longer_than_allowed(seen: list[tuple[float, float]]) -> None:
    feedback = Feedback(1, gain=5.0, largest=0.02)
    for off, seconds in seen:
        feedback.observe(np.full((1, 3), off), np.zeros((1, 3)), seconds)
        assert np.linalg.norm(feedback.correction) <= 0.02 * (1.0 + 1e-12)


def test_long_pauses_do_not_overshoot() -> None:
    feedback = Feedback(1, gain=50.0, largest=1.0)
    feedback.observe(OFF, np.zeros((1, 3)), 100.0)
    np.testing.assert_allclose(feedback.correction, OFF)
    feedback.reset()
    assert not feedback.correction.any()


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_model_that_is_lost_corrects_nothing(bad: float) -> None:
    feedback = Feedback(1, gain=5.0, largest=0.02)
    feedback.observe(np.full((1, 3), bad), np.zeros((1, 3)), 1.0)
    assert not feedback.correction.any()
