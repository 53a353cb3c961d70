"""Small QPs within kernels, against daqp, and the factor of their objective."""

from __future__ import annotations

import numpy as np
import pytest

from tauten.controller.friction.dual_qp import solve_dual
from tauten.controller.friction.effort_step import objective_root
from tauten.controller.qpcc import UNBOUNDED, Qp, solve_daqp


@pytest.mark.parametrize("seed", range(4))
def test_the_answer_is_that_of_daqp(seed: int) -> None:
    """Limits of one side and two, more of them than variables, repeated rows, fixed variables."""
    rng = np.random.default_rng(seed)
    for n in (1, 2, 3, 6, 9):
        root, A = rng.normal(size=(n + 1, n)), rng.normal(size=(n + 2, n))
        A[-1] = A[0]
        H, f = root.T @ root, 10.0 * rng.normal(size=n)
        lower, upper = -rng.uniform(0.0, 1.0, 2 * n + 2), rng.uniform(0.0, 1.0, 2 * n + 2)
        lower[rng.integers(2 * n + 2)], upper[rng.integers(2 * n + 2)] = -UNBOUNDED, UNBOUNDED
        lower[n - 1] = upper[n - 1] = 0.0
        solved, y = solve_dual(H, f, A, lower, upper)
        assert solved
        assert y == pytest.approx(solve_daqp(Qp(H, f, A, lower, upper)).y, abs=1e-8)
        values = np.concatenate([y, A @ y])
        assert (values >= lower - 1e-9).all()
        assert (values <= upper + 1e-9).all()


def test_a_singular_hessian_ends_at_a_limit_or_where_nothing_pulls() -> None:
    H, A = np.array([[1.0, 1.0], [1.0, 1.0]]), np.zeros((0, 2))
    solved, y = solve_dual(H, np.array([-3.0, -3.0]), A, np.zeros(2), np.full(2, 2.0))
    assert solved
    assert y.sum() == pytest.approx(3.0, abs=1e-6)
    solved, y = solve_dual(0.0 * H, np.zeros(2), A, np.zeros(2), np.full(2, 2.0))
    assert solved
    assert (y == 0.0).all()


def test_limits_that_exclude_one_another_and_numbers_that_are_none_are_not_solved() -> None:
    H, A = np.eye(1), np.ones((1, 1))
    excluded = np.array([1.0, -5.0]), np.array([2.0, 0.0])
    assert not solve_dual(H, np.zeros(1), A, *excluded)[0]
    assert not solve_dual(np.nan * H, np.zeros(1), A, np.zeros(2), np.ones(2))[0]
    assert not solve_dual(H, np.full(1, np.nan), A, np.zeros(2), np.ones(2))[0]


def test_the_energy_of_efforts_is_not_lost_beside_an_object_that_nothing_holds() -> None:
    """Rounding of its compliance is larger, and a factor of both together ends before the energy."""
    moves = np.array([[0.0, 0.0, 14.0]])
    energy, Q = 1e-14 * np.eye(2), moves.T @ moves
    Q[:2, :2] += energy
    root = objective_root(Q, energy)
    found = np.square(root.T @ np.array([1.0, -1.0, 0.0])).sum()
    assert found == pytest.approx(2e-14, rel=1e-9)
    np.testing.assert_allclose(root @ root.T, Q, rtol=1e-12, atol=1e-12)
