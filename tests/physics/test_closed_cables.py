"""Cables whose segments close: a cable pulls two parts of the body together until they meet."""

from __future__ import annotations

import numpy as np
import pytest

from tauten.model.points import add_beam_cable_stiffness, combinations, make_paths
from tauten.model.points.cable import add_cable_stiffness
from tauten.model.points.paths import SHORTEST, blunted, path_lengths
from tauten.reduction.state.beams.loads import effort_rows

WEIGHTS = np.array([[-0.4, -0.3, -0.2, -0.1, 0.1, 0.2, 0.3, 0.4]])
STARTS, SHORT = np.array([0, 2]), np.array([SHORTEST])
SEGMENTS = np.zeros(1, dtype=np.int64), np.zeros(1, dtype=np.int64), SHORT


def segment(distance: float) -> np.ndarray:
    """Positions (8, 3) [m] of the nodes of one segment with a distance between its ends."""
    generator = np.random.default_rng(1)
    x = 1e-3 * generator.standard_normal((8, 3))
    d = WEIGHTS[0] @ x
    direction = np.array([2.0, -1.0, 2.0]) / 3.0
    x[4:] += distance * direction - d
    return x


def ends(x: np.ndarray) -> np.ndarray:
    """Both ends (2, 3) of the segment [m]."""
    return np.stack([-WEIGHTS[0, :4] @ x[:4], WEIGHTS[0, 4:] @ x[4:]])


def gradient(x: np.ndarray) -> np.ndarray:
    """Derivative of the segment's length by all positions: (24,)."""
    shorter = path_lengths(ends(x), STARTS, SHORT)[1]
    return (np.repeat([shorter[0], -shorter[1]], 4, axis=0) * WEIGHTS[0][:, None]).ravel()


@pytest.mark.parametrize("share", [0.0, 0.3, 0.95, 3.0])
def test_lengths_gradients_and_curvatures_agree(share: float) -> None:
    x, step = segment(share * SHORTEST), 1e-7
    moves = step * np.eye(24).reshape(24, 8, 3)
    lengths = [
        [path_lengths(ends(x + sign * move), STARTS, SHORT)[0][0] for move in moves]
        for sign in (1.0, -1.0)
    ]
    assert np.allclose((np.array(lengths[0]) - lengths[1]) / (2.0 * step), gradient(x), atol=1e-6)
    slopes = np.array([gradient(x + move) - gradient(x - move) for move in moves]) / (2.0 * step)
    K = np.zeros(24 * 24)
    slot = (3 * np.arange(8)[:, None] + 24 * 3 * np.arange(8))[None]
    column_length = np.full((1, 8), 24, dtype=np.int64)
    add_cable_stiffness(ends(x), SEGMENTS, WEIGHTS, np.array([1.0]), (slot, column_length), K)
    tangent = K.reshape(24, 24).T
    assert np.allclose(tangent, slopes, atol=1e-4 * np.abs(tangent).max())
    assert np.linalg.eigvalsh(tangent).min() > -1e-9 * np.abs(tangent).max()


@pytest.mark.parametrize("share", [0.0, 0.3, 0.95, 3.0])
def test_curvatures_of_beams_agree_with_gradients(share: float) -> None:
    """Of full bodies, without lever arms, and of reduced ones."""
    tension, step = np.array([2.0]), 1e-7
    y = np.array([[0.01, 0.0, 0.02], [0.01, 0.0, 0.02]])
    y[1] += share * SHORTEST * np.array([2.0, -1.0, 2.0]) / 3.0
    moves = step * np.eye(6).reshape(6, 2, 3)
    slopes = [
        path_lengths(y - move, STARTS, SHORT)[1] - path_lengths(y + move, STARTS, SHORT)[1]
        for move in moves
    ]
    expected = tension[0] * np.array(slopes).reshape(6, 6) / (2.0 * step)
    Z, Y = np.empty((3, 6)), np.empty((3, 6))
    effort_rows(y, SEGMENTS, tension, np.eye(6), Z, Y)
    K, blocks = np.zeros(144), (3 * np.arange(4)[:, None] + 36 * np.arange(4))[None]
    column_length = np.full((1, 4), 12, dtype=np.int64)
    places = (blocks, column_length)
    add_beam_cable_stiffness(y, np.zeros((2, 2, 3)), SEGMENTS, tension, False, places, K)
    own = np.array([0, 1, 2, 6, 7, 8])  # positions of both nodes
    for tangent in (Z.T @ Y, K.reshape(12, 12)[own[:, None], own]):
        np.testing.assert_allclose(tangent, expected, atol=1e-4 * np.abs(expected).max())


def test_longer_segments_keep_their_length() -> None:
    assert blunted(1.001 * SHORTEST, SHORTEST)[0] == 1.001 * SHORTEST
    assert 0.0 < blunted(0.0, SHORTEST)[0] < SHORTEST


@pytest.mark.parametrize("size", [1.0, 0.01])
def test_cables_of_small_robots_are_as_straight_as_those_of_large_ones(size: float) -> None:
    """Segments of 10 mm and of 0.1 mm lengthen by what their ends move, by up to a half."""
    corners = size * 0.01 * np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [2, 1, 1]])
    points = combinations(np.arange(16).reshape(4, 4), np.tile([1.0, 0.0, 0.0, 0.0], (4, 1)))
    x = np.repeat(corners, 4, axis=0)
    paths = make_paths([len(points)], points.at(x))
    for stretch in (0.55, 1.0, 1.4):
        length, shorter = path_lengths(stretch * corners, paths.starts, paths.shortest)
        assert length[0] == pytest.approx(stretch * size * 0.01 * (2.0 + 2.0**0.5), rel=1e-12)
        assert np.linalg.norm(shorter[[0, 3]], axis=1) == pytest.approx(np.ones(2), rel=1e-12)
