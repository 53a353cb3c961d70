"""Targets: only while armed, within reach, and where the effectors are before."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tauten.service.frames import TargetStore
from tauten.service.wire import reach_of

REST, SIZE = np.array([[0.1, 0.0, 0.0], [0.05, 0.0, 0.0]]), 0.1
NUMBERS = st.floats(allow_nan=True, allow_infinity=True)


@given(st.tuples(NUMBERS, NUMBERS, NUMBERS), st.integers(0, 1))
def test_targets_are_finite_and_within_reach(position: tuple[float, ...], effector: int) -> None:
    targets = TargetStore(REST, SIZE)
    targets.arm(True)
    targets.put(effector, position)
    goal = targets.goal()
    assert goal is not None
    assert np.isfinite(goal).all()
    away = np.linalg.norm(goal - REST, axis=1)
    assert away.max() <= reach_of(SIZE)
    asked = np.array(position)
    if np.isfinite(asked).all() and np.abs(asked - REST[effector]).max() < 0.5 * reach_of(SIZE):
        assert goal[effector] == pytest.approx(asked)


def test_there_are_none_while_disarmed() -> None:
    targets = TargetStore(REST, SIZE)
    targets.put(0, (0.1, 0.0, 0.05))
    assert targets.goal() is None
    assert np.array_equal(targets.positions, REST)


def test_arming_starts_where_the_robot_is() -> None:
    targets = TargetStore(REST, SIZE)
    moved = REST + 0.01
    targets.rest_at(moved)
    targets.arm(True)
    goal = targets.goal()
    assert goal is not None
    assert np.array_equal(goal, moved)
    targets.rest_at(REST)  # a robot that follows does not move its target
    assert np.array_equal(targets.positions, moved)


def test_a_robot_that_has_blown_up_does_not_move_its_target() -> None:
    targets = TargetStore(REST, SIZE)
    targets.rest_at(np.full_like(REST, np.nan))
    assert np.array_equal(targets.positions, REST)
