"""Targets: only while armed, within reach, and where the effectors are before."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.messages import effector

from tauten.service.frames import TargetStore, WaypointList
from tauten.service.wire import reach_of

REST, SIZE = np.array([[0.1, 0.0, 0.0], [0.05, 0.0, 0.0]]), 0.1
POINTS = tuple(
    effector(name, "point", *row)
    for name, row in zip(("tip", "middle"), REST.tolist(), strict=True)
)
MIXED = (
    effector("hand", "frame", 0.1, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0),
    effector("gap", "distance", 0.02),
)
NUMBERS = st.floats(allow_nan=True, allow_infinity=True)


@given(st.tuples(NUMBERS, NUMBERS, NUMBERS), st.integers(0, 1))
def test_targets_are_finite_and_within_reach(position: tuple[float, ...], effector: int) -> None:
    targets = TargetStore(POINTS, SIZE)
    targets.arm(True)
    targets.put(effector, position)
    goal = targets.goal()
    assert goal is not None
    assert np.isfinite(goal).all()
    goal = goal.reshape(-1, 3)
    away = np.linalg.norm(goal - REST, axis=1)
    assert away.max() <= reach_of(SIZE)
    asked = np.array(position)
    if np.isfinite(asked).all() and np.abs(asked - REST[effector]).max() < 0.5 * reach_of(SIZE):
        assert goal[effector] == pytest.approx(asked)


def test_there_are_none_while_disarmed() -> None:
    targets = TargetStore(POINTS, SIZE)
    targets.put(0, (0.1, 0.0, 0.05))
    assert targets.goal() is None
    assert np.array_equal(targets.values, REST.ravel())


def test_arming_starts_where_the_robot_is() -> None:
    targets = TargetStore(POINTS, SIZE)
    moved = REST + 0.01
    targets.rest_at(moved.ravel())
    targets.arm(True)
    goal = targets.goal()
    assert goal is not None
    assert np.array_equal(goal, moved.ravel())
    targets.rest_at(REST.ravel())  # a robot that follows does not move its target
    assert np.array_equal(targets.values, moved.ravel())


def test_a_robot_that_has_blown_up_does_not_move_its_target() -> None:
    targets = TargetStore(POINTS, SIZE)
    targets.rest_at(np.full(6, np.nan))
    assert np.array_equal(targets.values, REST.ravel())


@given(st.lists(NUMBERS, min_size=0, max_size=8))
def test_rotations_have_length_one_and_scalars_a_range(values: list[float]) -> None:
    targets = TargetStore(MIXED, SIZE)
    targets.arm(True)
    targets.put(0, tuple(values))
    targets.put(1, tuple(values))
    hand, gap = targets.of(0), targets.of(1)
    assert np.linalg.norm(hand[3:]) == pytest.approx(1.0)
    assert np.linalg.norm(hand[:3] - MIXED[0].rest[:3]) <= reach_of(SIZE)
    assert 0.01 <= gap[0] <= 0.04


def test_a_frame_is_moved_and_turned() -> None:
    targets = TargetStore(MIXED, SIZE)
    targets.arm(True)
    targets.put(0, (0.1, 0.0, 0.01, 0.0, 0.0, 0.0, 2.0))
    assert targets.of(0) == pytest.approx([0.1, 0.0, 0.01, 0.0, 0.0, 0.0, 1.0])


@pytest.mark.parametrize("rest", [-0.02, 0.0, 0.03])
@pytest.mark.parametrize(("asked", "kept"), [(0.004, 0.004), (-0.5, -SIZE), (0.5, SIZE)])
def test_a_function_of_another_package_may_be_zero_or_negative_at_rest(
    rest: float, asked: float, kept: float
) -> None:
    """Of one that is zero no target but zero could be given, of a negative one only twice that at rest."""
    one = effector("height", "function", rest)
    targets = TargetStore((one,), SIZE)
    targets.arm(True)
    targets.put(0, np.array([rest + asked]))
    assert targets.of(0) == pytest.approx([rest + kept])
    waypoints = WaypointList(one, SIZE)
    waypoints.add(targets.of(0))
    assert waypoints.names() == (f"1: {1e3 * (rest + kept):.1f} mm",)
