"""Dense LU with complete pivoting for small matrices that are often singular, symmetric or not.

LAPACK has no rank-revealing LU, and a call into it costs more than the elimination itself here.
Golub and Van Loan, Matrix Computations, 4th ed., section 3.4.8.
"""

from __future__ import annotations

import numpy as np

from tauten.model.numerics.arrays import Array, Ints
from tauten.model.numerics.jit import kernel

RANK = 1e-10  # pivots below this, relative to the largest, count as zero; well above round-off


@kernel
def eliminate(E: Array, X: Array) -> tuple[int, Ints, Ints]:
    """LU of E (p, p) in place, complete pivoting; X (p, q) takes part in the row operations.

    Returns:
        The rank, the order of the rows and the order of the columns.
    """
    p = len(E)
    rows, cols = np.arange(p), np.arange(p)
    first = 0.0
    for s in range(p):
        i, j = largest_entry(E, s)
        size = abs(E[i, j])
        first = max(first, size)
        if size <= RANK * first:
            return s, rows, cols
        swap_rows(E, s, i)
        swap_rows(X, s, i)
        rows[s], rows[i] = rows[i], rows[s]
        swap_columns(E, s, j)
        cols[s], cols[j] = cols[j], cols[s]
        clear_below(E, X, s)
    return p, rows, cols


@kernel
def largest_entry(E: Array, s: int) -> tuple[int, int]:
    """Where the largest magnitude of E[s:, s:] is."""
    best, i_best, j_best = -1.0, s, s
    for i in range(s, len(E)):
        for j in range(s, len(E)):
            if abs(E[i, j]) > best:
                best, i_best, j_best = abs(E[i, j]), i, j
    return i_best, j_best


@kernel
def swap_rows(E: Array, s: int, i: int) -> None:
    """Exchange two rows.

    Args:
        E: (p, q), changed in place.
        s: number of one row.
        i: number of the other.
    """
    if i != s:
        for j in range(E.shape[1]):
            E[s, j], E[i, j] = E[i, j], E[s, j]


@kernel
def swap_columns(E: Array, s: int, j: int) -> None:
    """Exchange two columns.

    Args:
        E: (p, q), changed in place.
        s: number of one column.
        j: number of the other.
    """
    if j != s:
        for i in range(len(E)):
            E[i, s], E[i, j] = E[i, j], E[i, s]


@kernel
def clear_below(E: Array, X: Array, s: int) -> None:
    """Subtract row s from the rows below it, leaving the factors of L in column s.

    Args:
        E: (p, p), changed in place.
        X: (p, q), takes part in the row operations.
        s: number of the row.
    """
    for i in range(s + 1, len(E)):
        factor = E[i, s] / E[s, s]
        E[i, s] = factor
        for j in range(s + 1, len(E)):
            E[i, j] -= factor * E[s, j]
        for j in range(X.shape[1]):
            X[i, j] -= factor * X[s, j]


@kernel
def solve_upper(E: Array, X: Array, rank: int) -> None:
    """X[:rank] <- U⁻¹ X[:rank], with U the upper triangle of E[:rank, :rank].

    Args:
        E: (p, p) of `eliminate`.
        X: (p, q), changed in place.
        rank: of E.
    """
    for s in range(rank - 1, -1, -1):
        for j in range(X.shape[1]):
            total = X[s, j]
            for i in range(s + 1, rank):
                total -= E[s, i] * X[i, j]
            X[s, j] = total / E[s, s]


@kernel
def solve_transposed(E: Array, x: Array, rank: int) -> None:
    """X[:rank] <- (L U)⁻ᵀ x, with the triangles of E[:rank, :rank]; the order is the pivots'.

    Args:
        E: (p, p) of `eliminate`.
        x: (p,), changed in place.
        rank: of E.
    """
    for s in range(rank):
        for i in range(s):
            x[s] -= E[i, s] * x[i]
        x[s] /= E[s, s]
    for s in range(rank - 1, -1, -1):
        for i in range(s + 1, rank):
            x[s] -= E[i, s] * x[i]
