"""Linear systems within kernels: of LAPACK, and small ones by elimination, which costs less than to call it.

Golub and Van Loan, Matrix Computations, 4th ed., section 3.4: elimination with partial pivoting, here of the
right-hand sides, too, which are beside the matrix.
"""

from __future__ import annotations

import numpy as np

from tauten.model.numerics.arrays import Array
from tauten.model.numerics.elimination import swap_rows
from tauten.model.numerics.jit import kernel

SMALL = 32  # unknowns, up to which elimination takes less time than LAPACK
AT_ONCE = 4  # rows that a pivot is subtracted from together


@kernel
def solve_linear(A: Array, B: Array) -> tuple[bool, Array]:
    """Whether A (n, n) and B are finite and A has an inverse, and A⁻¹ B (n, k), which is zero otherwise."""
    if len(A) <= SMALL:
        return _eliminated(A, B)
    X = np.zeros(B.shape)
    try:
        X = np.ascontiguousarray(np.linalg.solve(A, B))
    except Exception:  # numba knows no other class here
        return False, X
    return True, X


@kernel
def _eliminated(A: Array, B: Array) -> tuple[bool, Array]:
    """`solve_linear` of few unknowns."""
    n, k = B.shape
    E, finite = _side_by_side(A, B)
    for s in range(n):
        pivot = s
        for i in range(s + 1, n):
            if abs(E[i, s]) > abs(E[pivot, s]):
                pivot = i
        if not finite or E[pivot, s] == 0.0:
            return False, np.zeros((n, k))
        swap_rows(E, s, pivot)
        inverse = 1.0 / E[s, s]
        for j in range(s + 1, n + k):
            E[s, j] *= inverse
        _subtract(E, s, s + 1, n, s + 1)
    for s in range(n - 1, 0, -1):
        _subtract(E, s, 0, s, n)
    return True, E[:, n:].copy()


@kernel
def _side_by_side(A: Array, B: Array) -> tuple[Array, bool]:
    """A (n, n) and B (n, k) in one array (n, n + k), and whether all entries are finite."""
    n, k = B.shape
    E, total = np.empty((n, n + k)), 0.0
    for i in range(n):
        for j in range(n):
            E[i, j] = A[i, j]
            total += abs(A[i, j])
        for j in range(k):
            E[i, n + j] = B[i, j]
            total += abs(B[i, j])
    return E, total < np.inf


@kernel
def _subtract(E: Array, s: int, first: int, end: int, column: int) -> None:
    """Subtract row s from some rows, as often as their entries in column s say.

    Args:
        E: (n, m), changed in place.
        s: number of the row.
        first: of the rows.
        end: one past the last of them.
        column: from which on they are changed.
    """
    top, i = E[s], first
    while i + AT_ONCE <= end:
        a, b, c, d = E[i], E[i + 1], E[i + 2], E[i + 3]
        of_a, of_b, of_c, of_d = a[s], b[s], c[s], d[s]
        for j in range(column, len(top)):
            a[j] -= of_a * top[j]
            b[j] -= of_b * top[j]
            c[j] -= of_c * top[j]
            d[j] -= of_d * top[j]
        i += AT_ONCE
    while i < end:
        a, of_a = E[i], E[i, s]
        for j in range(column, len(top)):
            a[j] -= of_a * top[j]
        i += 1
