"""The updated factor is the factor of what is left, after any comings and goings."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from tauten.model.numerics import append_row, back_substitute, delete_row, forward_substitute

SIZE = 12


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 10_000), st.lists(st.integers(0, SIZE - 1), min_size=1, max_size=40))
def test_factor_follows_its_matrix(seed: int, toggled: list[int]) -> None:
    """Each number toggled enters the set, or leaves it when it is inside."""
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((SIZE, SIZE))
    M = A @ A.T + 0.1 * np.eye(SIZE)
    L, members = np.full((SIZE, SIZE), np.nan), []
    for number in toggled:
        if number in members:
            k = members.index(number)
            delete_row(L, len(members), k)
            members.pop(k)
        else:
            column = np.append(M[number, members], np.nan)
            append_row(L, len(members), column, M[number, number], 1e-12)
            members.append(number)
    f = len(members)
    part = M[np.ix_(members, members)]
    factor = np.tril(L[:f, :f])
    np.testing.assert_allclose(factor @ factor.T, part, atol=1e-10)
    b = rng.standard_normal(f)
    y = b.copy()
    forward_substitute(L, f, y)
    back_substitute(L, f, y)
    np.testing.assert_allclose(part @ y, b, atol=1e-8)


def test_singular_row_is_kept_above_the_floor() -> None:
    """A row equal to an earlier one leaves nothing for the diagonal but the floor."""
    L = np.zeros((2, 2))
    append_row(L, 0, np.zeros(1), 1.0, 1e-9)
    append_row(L, 1, np.array([1.0, 0.0]), 1.0, 1e-9)
    np.testing.assert_allclose(L, [[1.0, 0.0], [1.0, np.sqrt(1e-9)]])
