"""Rotations of deformation gradients against scipy's polar decomposition."""

import numpy as np
import pytest
from scipy.linalg import polar

from tauten.model.numerics import LANES, polar_rotations


def rotations(F: np.ndarray) -> np.ndarray:
    """Of matrices (n, 3, 3)."""
    R = np.full_like(F, np.nan)
    polar_rotations(F, R)
    return R


def stretched(rng: np.random.Generator, n: int, size: float) -> np.ndarray:
    """Rotated and sheared bodies without inversion: (n, 3, 3)."""
    F = np.empty((n, 3, 3))
    for e in range(n):
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        turn *= np.sign(np.linalg.det(turn))
        stretch = rng.normal(size=(3, 3))
        F[e] = turn @ (0.05 * np.eye(3) + size * stretch @ stretch.T)
    return F


@pytest.mark.parametrize("n", [1, LANES - 1, LANES, 3 * LANES + 5])
@pytest.mark.parametrize("size", [1e-3, 1.0, 30.0])
def test_rotations_are_those_of_the_polar_decomposition(n: int, size: float) -> None:
    F = stretched(np.random.default_rng(n), n, size)
    expected = np.array([polar(matrix)[0] for matrix in F])
    np.testing.assert_allclose(rotations(F), expected, atol=1e-11)


def test_nothing_to_do() -> None:
    assert rotations(np.zeros((0, 3, 3))).shape == (0, 3, 3)


def test_inverted_elements_get_a_rotation_and_leave_others_alone() -> None:
    rng = np.random.default_rng(5)
    F = stretched(rng, 2 * LANES, 1.0)
    whole = rotations(F)
    inverted = np.arange(0, 2 * LANES, 3)
    F[inverted, :, 0] *= -1.0
    F[inverted[0]] = 0.0
    R = rotations(F)
    np.testing.assert_allclose(
        R @ np.swapaxes(R, 1, 2), np.tile(np.eye(3), (len(F), 1, 1)), atol=1e-12
    )
    np.testing.assert_allclose(np.linalg.det(R), 1.0, atol=1e-12)
    others = np.setdiff1d(np.arange(len(F)), inverted)
    np.testing.assert_allclose(R[others], whole[others], atol=1e-14)
    # the smallest stretch alone is negative
    S = np.swapaxes(R, 1, 2)[inverted[1:]] @ F[inverted[1:]]
    values = np.linalg.eigvalsh(0.5 * (S + np.swapaxes(S, 1, 2)))
    assert (values[:, 0] < 0.0).all()
    assert (values[:, 1:] > 0.0).all()
    assert (np.abs(values[:, 0]) < values[:, 1]).all()


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("entry", [(0, 0), (1, 1), (2, 1)])
def test_matrices_that_are_not_finite_do_not_change_others(
    bad: float, entry: tuple[int, int]
) -> None:
    F = stretched(np.random.default_rng(1), LANES, 1.0)
    whole = rotations(F)
    F[(3, *entry)] = bad
    R = rotations(F)
    assert not np.isfinite(R[3]).all()
    others = np.arange(LANES) != 3
    np.testing.assert_allclose(R[others], whole[others], atol=1e-14)
