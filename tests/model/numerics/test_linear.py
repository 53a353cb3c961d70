"""Linear systems within kernels, small ones by elimination and others by LAPACK."""

from __future__ import annotations

import numpy as np
import pytest

from tauten.model.numerics import solve_linear


@pytest.mark.parametrize("n", [1, 2, 5, 7, 18, 32, 33, 60])
def test_residuals_are_rounding(n: int) -> None:
    """Also where zeros on the diagonal ask for other pivots, and rows are of very different sizes."""
    rng = np.random.default_rng(n)
    for k in (1, 2, 10):
        A, B = rng.normal(size=(n, n)), rng.normal(size=(n, k))
        A[np.arange(n - 1), np.arange(n - 1)] = 0.0
        A *= 10.0 ** rng.uniform(-6, 6, n)[:, None]
        solved, X = solve_linear(A, B)
        assert solved
        scale = np.abs(A) @ np.abs(X) + np.abs(B)
        assert (np.abs(A @ X - B) < 1e-10 * scale).all()


@pytest.mark.parametrize("n", [3, 32, 40])
@pytest.mark.parametrize("wrong", [0.0, np.nan, np.inf])
def test_what_has_no_solution_says_so(n: int, wrong: float) -> None:
    """A matrix with a column of zeros, and numbers that are none."""
    A = np.random.default_rng(n).normal(size=(n, n))
    A[:, n // 2] = wrong
    solved, X = solve_linear(A, np.ones((n, 2)))
    assert not solved
    assert not X.any()


def test_right_hand_sides_are_finite() -> None:
    assert not solve_linear(np.eye(4), np.full((4, 1), np.nan))[0]
