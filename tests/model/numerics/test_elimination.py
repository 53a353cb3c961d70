"""LU with complete pivoting: rank, solutions, solutions with the transpose."""

import numpy as np
import pytest

from tauten.model.numerics import Array, Ints, eliminate, solve_transposed, solve_upper


@pytest.mark.parametrize("rank", [6, 3, 1, 0])
def test_elimination_finds_rank_and_solution(rank: int) -> None:
    rng = np.random.default_rng(5)
    matrix = rng.normal(size=(6, rank)) @ rng.normal(size=(rank, 6))
    solution = rng.normal(size=(6, 2))
    E, X = matrix.copy(), matrix @ solution
    found, rows, cols = eliminate(E, X)
    assert found == rank
    solve_upper(E, X, found)
    basic = np.zeros((6, 2))
    basic[cols[:found]] = X[:found]
    np.testing.assert_allclose(matrix @ basic, matrix @ solution, atol=1e-10)
    assert_transposed(matrix, E, rows[:found], cols[:found], rng.normal(size=found))


def assert_transposed(matrix: Array, E: Array, rows: Ints, cols: Ints, x: Array) -> None:
    """`solve_transposed` solves with the transpose of the eliminated block."""
    block = matrix[np.ix_(rows, cols)]
    y = x.copy()
    solve_transposed(E, y, len(x))
    np.testing.assert_allclose(block.T @ y, x, atol=1e-9)
