"""A Cholesky factor that is updated when single rows and columns are added or removed.

M = L Lᵀ with L lower triangular in the first f rows and columns of a larger array. Adding or removing
one row costs f² operations instead of f³.
"""

from __future__ import annotations

import numpy as np

from tauten.model.numerics.arrays import Array
from tauten.model.numerics.jit import kernel


@kernel
def forward_substitute(L: Array, f: int, b: Array) -> None:
    """Overwrite b with L⁻¹ b; both of size f.

    Args:
        L: array that begins with the factor.
        f: size of the factor.
        b: (f,) right-hand side, overwritten.
    """
    for i in range(f):
        value = b[i]
        for j in range(i):
            value -= L[i, j] * b[j]
        b[i] = value / L[i, i]


@kernel
def back_substitute(L: Array, f: int, b: Array) -> None:
    """Overwrite b with L⁻ᵀ b; both of size f.

    Args:
        L: array that begins with the factor.
        f: size of the factor.
        b: (f,) right-hand side, overwritten.
    """
    for i in range(f - 1, -1, -1):
        b[i] /= L[i, i]
        for j in range(i):
            b[j] -= L[i, j] * b[i]


@kernel
def append_row(L: Array, f: int, column: Array, diagonal: float, floor: float) -> None:
    """Grow the factor from size f to f + 1.

    Args:
        L: array larger than the factor.
        f: its size before.
        column: new off-diagonal entries of M, the first f are read; overwritten.
        diagonal: new diagonal entry of M.
        floor: least square of the factor's new diagonal, against rounding.
    """
    forward_substitute(L, f, column)
    rest = diagonal
    for j in range(f):
        L[f, j] = column[j]
        rest -= column[j] * column[j]
    L[f, f] = np.sqrt(max(rest, floor))


@kernel
def delete_row(L: Array, f: int, k: int) -> None:
    """Shrink the factor from size f to f − 1: row and column k of M are removed.

    The rows below move up, which leaves one entry above the diagonal in each; Givens rotations of the columns
    eliminate it.

    Args:
        L: array that begins with the factor, overwritten.
        f: size of the factor before.
        k: the row.
    """
    for i in range(k, f - 1):
        for j in range(i + 2):
            L[i, j] = L[i + 1, j]
    for j in range(k, f - 1):
        a, b = L[j, j], L[j, j + 1]
        length = np.hypot(a, b)
        c, s = a / length, b / length
        for i in range(j, f - 1):
            x, y = L[i, j], L[i, j + 1]
            L[i, j] = c * x + s * y
            L[i, j + 1] = c * y - s * x
