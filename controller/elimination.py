"""Dense LU with complete pivoting for matrices of contact modes: small, often singular.

LAPACK has no rank-revealing LU, and a call into it costs more than the elimination itself at these sizes.
Golub and Van Loan, Matrix Computations, 4th ed., section 3.4.8.
"""

from __future__ import annotations

import numpy as np
from tauten.model.arrays import Array, Ints
from tauten.model.jit import kernel

RANK = 1e-11  # pivots below this, relative to the largest, count as zero; well above round-off


@kernel
def eliminate(E: Array, X: Array) -> tuple[int, Ints, Ints]:
    """LU of E (p, p) in place, complete pivoting; X (p, q) takes part in the row operations.

    Returns:
        The rank, the order of the rows and the order of the columns.
    """
    p, q = len(E), X.shape[1]
    rows, cols = np.arange(p), np.arange(p)
    first = 0.0
    for s in range(p):
        best, i_best, j_best = 0.0, s, s
        for i in range(s, p):
            for j in range(s, p):
                if abs(E[i, j]) > best:
                    best, i_best, j_best = abs(E[i, j]), i, j
        first = max(first, best)
        if best <= RANK * first:
            return s, rows, cols
        if i_best != s:
            rows[s], rows[i_best] = rows[i_best], rows[s]
            for j in range(p):
                E[s, j], E[i_best, j] = E[i_best, j], E[s, j]
            for j in range(q):
                X[s, j], X[i_best, j] = X[i_best, j], X[s, j]
        if j_best != s:
            cols[s], cols[j_best] = cols[j_best], cols[s]
            for i in range(p):
                E[i, s], E[i, j_best] = E[i, j_best], E[i, s]
        for i in range(s + 1, p):
            factor = E[i, s] / E[s, s]
            E[i, s] = factor
            for j in range(s + 1, p):
                E[i, j] -= factor * E[s, j]
            for j in range(q):
                X[i, j] -= factor * X[s, j]
    return p, rows, cols


@kernel
def back_substitute(E: Array, X: Array, rank: int) -> None:
    """X[:rank] <- U⁻¹ X[:rank], with U the upper triangle of E[:rank, :rank]."""
    q = X.shape[1]
    for s in range(rank - 1, -1, -1):
        for i in range(s + 1, rank):
            for j in range(q):
                X[s, j] -= E[s, i] * X[i, j]
        for j in range(q):
            X[s, j] /= E[s, s]


@kernel
def solve_transposed(E: Array, x: Array, rank: int) -> None:
    """X[:rank] <- (L U)⁻ᵀ x, with the triangles of E[:rank, :rank]; the order is the pivots'."""
    for s in range(rank):
        for i in range(s):
            x[s] -= E[i, s] * x[i]
        x[s] /= E[s, s]
    for s in range(rank - 1, -1, -1):
        for i in range(s + 1, rank):
            x[s] -= E[i, s] * x[i]
