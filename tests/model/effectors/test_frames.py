"""Frames: rotation of rigidly moved nodes, mirrored and flat regions, quaternions of either sign."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from support.effectors import BEAM_KINDS, END, beams, disturbed, moved, solid

from tauten.model import EffectorLayout, Pose, Robot, State
from tauten.model.effectors import FrameMeasure, frame_coefficients
from tauten.model.numerics import Array, matrix_quaternion, rotated_by, rotation_between
from tauten.model.points import NodeMotion
from tauten.model.tetra import NodalBody

FRAME = {"name": "tool", "kind": "frame", "region": END, "point": [0.12, 0.0, 0.01]}
vectors = st.lists(st.floats(-3.0, 3.0), min_size=3, max_size=3).map(np.array)


def wxyz(rotation: Rotation) -> Array:
    found: Array = rotation.as_quat()[[3, 0, 1, 2]]
    return found if found[0] >= 0.0 else -found


@pytest.fixture(scope="module")
def framed() -> Robot[NodalBody]:
    """A solid with a frame."""
    return solid([FRAME])


@settings(max_examples=50)
@given(turn=vectors, shift=vectors)
def test_a_rigid_motion_of_all_nodes_is_that_of_the_frame(
    framed: Robot[NodalBody], turn: Array, shift: Array
) -> None:
    robot, rotation = framed, Rotation.from_rotvec(turn)
    x = rotation.apply(robot.body.mesh.nodes) + shift
    values = robot.effectors.values(NodeMotion(x, robot.body.pattern.dof, robot.n))
    np.testing.assert_allclose(values[:3], rotation.apply([0.12, 0.0, 0.01]) + shift, atol=1e-12)
    assert Rotation.from_quat(values[[4, 5, 6, 3]]).approx_equal(rotation, atol=1e-10)


@settings(max_examples=50, deadline=None)
@given(vectors)
def test_quaternion_matrix_and_vector_are_one_rotation(turn: Array) -> None:
    rotation = Rotation.from_rotvec(turn)
    q = matrix_quaternion(rotation.as_matrix())
    np.testing.assert_allclose(q, wxyz(rotation), atol=1e-9)
    start = wxyz(Rotation.from_rotvec([0.3, -0.2, 0.9]))
    r = rotation_between(start, q)
    expected = (Rotation.from_rotvec([0.3, -0.2, 0.9]).inv() * rotation).as_rotvec()
    assert Rotation.from_rotvec(r).approx_equal(Rotation.from_rotvec(expected), atol=1e-9)
    np.testing.assert_allclose(rotation_between(start, -q), r, atol=1e-9)
    assert abs(rotated_by(start, r) @ q) == pytest.approx(1.0, abs=1e-12)


def test_a_frame_of_beams_is_that_of_its_node(tmp_path: Path) -> None:
    robot = beams(tmp_path, [BEAM_KINDS[1]])
    state = disturbed(robot, np.random.default_rng(4), 0.1)
    values, (x, Q) = robot.effector_values(state), robot.body.pose(state)
    assert abs(values[3:] @ Q[5]) == pytest.approx(1.0, abs=1e-12)
    turned = Rotation.from_quat(Q[5][[1, 2, 3, 0]]).apply([0.05, 0.01, 0.0])
    np.testing.assert_allclose(values[:3], x[5] + turned, atol=1e-12)


def test_a_mirrored_region_has_a_right_handed_frame() -> None:
    rng = np.random.default_rng(5)
    rest = rng.standard_normal((20, 3))
    coefficients, measure = frame_coefficients(rest), FrameMeasure(np.zeros(3))
    mirrored = rest * [1.0, 1.0, -0.3]
    found = measure.at(coefficients @ mirrored)
    best, _ = Rotation.align_vectors(mirrored - mirrored.mean(axis=0), rest - rest.mean(axis=0))
    assert Rotation.from_quat(found.values[[4, 5, 6, 3]]).approx_equal(best, atol=1e-9)
    assert np.isfinite(found.gradient).all()


@pytest.mark.parametrize("squeezed", [0.0, 1e-12])
def test_a_region_that_is_crushed_has_finite_rows(squeezed: float) -> None:
    rest = np.random.default_rng(6).standard_normal((20, 3))
    found = FrameMeasure(np.ones(3)).at(frame_coefficients(rest) @ (squeezed * rest))
    assert np.isfinite(found.gradient).all()
    assert np.linalg.norm(found.values[3:]) == pytest.approx(1.0)


def layout() -> EffectorLayout:
    return solid([FRAME]).effector_layout


LAYOUT = layout()
REST = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])


def half_turn(angle: float) -> Array:
    return np.concatenate([np.zeros(3), wxyz(Rotation.from_rotvec([0.0, 0.0, angle]))])


def test_a_quaternion_and_its_negative_are_one_goal() -> None:
    goal = half_turn(0.7)
    other = goal * [1.0, 1.0, 1.0, -1.0, -1.0, -1.0, -1.0]
    np.testing.assert_array_equal(LAYOUT.row_targets(REST, goal), LAYOUT.row_targets(REST, other))
    np.testing.assert_allclose(LAYOUT.row_targets(REST, goal)[3:], [0.0, 0.0, 0.7])


def test_a_target_half_a_turn_away_does_not_jump() -> None:
    """Row targets change continuously where the target passes half a turn."""
    angles = np.linspace(0.0, 2.0 * np.pi, 721)
    targets = np.array([LAYOUT.row_targets(REST, half_turn(angle))[5] for angle in angles])
    step = angles[1]
    assert np.abs(np.diff(targets)).max() < 4.01 * step
    assert np.isfinite(targets).all()
    near = angles < 0.75 * np.pi
    np.testing.assert_allclose(targets[near], angles[near], atol=1e-12)
    assert (targets[(angles > 0.1) & (angles < np.pi - 0.1)] > 0.0).all()
    np.testing.assert_allclose(targets[::-1], -targets, atol=1e-9)


@settings(max_examples=100, deadline=None)
@given(vectors, vectors)
def test_difference_and_moved_are_inverse(first: Array, second: Array) -> None:
    start, end = (np.concatenate([v, wxyz(Rotation.from_rotvec(v))]) for v in (first, second))
    change = LAYOUT.difference(end, start)
    again = LAYOUT.moved(start, change)
    np.testing.assert_allclose(again[:3], end[:3], atol=1e-12)
    assert abs(again[3:] @ end[3:]) == pytest.approx(1.0, abs=1e-12)


def test_goals_are_checked() -> None:
    good = Pose((0.1, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))
    expected = [0.1, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]
    for target in (good, [good], expected, np.array(expected)):
        found = LAYOUT.goal_values(target)
        assert found is not None
        np.testing.assert_array_equal(found, expected)
    bad = [
        Pose((0.1, 0.0, 0.0), (1.1, 0.0, 0.0, 0.0)),
        Pose((0.1, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)),
        Pose((np.nan, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)),
        Pose((0.1, 0.0, 0.0), (1e200, 0.0, 0.0, 0.0)),  # whose square is infinite
    ]
    for target in bad:
        assert LAYOUT.goal_values(target) is None
    for other in ([0.1, 0.0, 0.0], [good, good], 1.0, "frame"):
        with pytest.raises(ValueError, match="expected a Pose for "):
            LAYOUT.goal_values(other)  # type: ignore[arg-type]


def test_a_frame_far_from_rest_is_moved_by_its_rows() -> None:
    """Values after a small change of the rows are those of the state it leads to."""
    robot = solid([FRAME])
    rng = np.random.default_rng(7)
    state = disturbed(robot, rng, 1e-3)
    dq = 1e-7 * rng.standard_normal(robot.n)
    rows = robot.rows(state, contacts=False).effectors
    expected = robot.effector_values(moved(robot, State(state.q, state.v), dq))
    found = robot.effector_layout.values_at(rows.values, rows.delta + rows.dense() @ dq)
    np.testing.assert_allclose(found, expected, atol=1e-12)
