"""A small strictly convex QP (5) within kernels: the dual active set of Goldfarb and Idnani (1983).

A path takes some ten thousand QPs a second, of one to ten variables; at that rate the way from Python to a
library and back would cost more than all else. From the unconstrained minimum limits are added while one is
exceeded, and dropped where their multiplier would become negative; with y = L⁻ᵀ x, H = L Lᵀ, the rows of the
active limits are N = C L⁻ᵀ, and the Cholesky factor of N Nᵀ is updated.
"""

from __future__ import annotations

import numpy as np

from tauten.model.numerics import (
    Array,
    append_row,
    back_substitute,
    cholesky,
    delete_row,
    forward_substitute,
    kernel,
)

YIELD = 1e-12  # curvature that a singular Hessian borrows, of variables of order one
CHANGES = 100  # of the active set, at most
WITHIN = 1e-10  # error of limits that are met
ROUNDING = 1e-14  # the same, of the unconstrained minimum
DEPENDENT = 1e-12  # share of a row's square that is left where active ones determine it


@kernel
def solve_dual(H: Array, f: Array, A: Array, lower: Array, upper: Array) -> tuple[bool, Array]:
    """Whether the QP (5) has been solved, and y (n,).

    Args:
        H: (n, n) positive semidefinite, with entries of order one.
        f: (n,).
        A: (m, n).
        lower: (n + m,).
        upper: (n + m,).
    """
    n, L, y = len(f), np.empty(H.shape), -f
    if not cholesky(H + YIELD * np.eye(n), L):
        return False, y
    forward_substitute(L, n, y)
    back_substitute(L, n, y)
    size = np.abs(y).max()
    allowed = WITHIN * min(size, 1.0) + ROUNDING * size
    N, R, nu = np.empty((n + 1, n)), np.empty((n + 1, n + 1)), np.empty(n + 1)
    count, left = 0, 0.0  # active limits, and by how much the one that is being added is exceeded
    v, s, z = np.empty(n), np.empty(n + 1), np.empty(n)
    for _ in range(CHANGES):
        if left <= 0.0:
            side, left = exceeded_most(A, lower, upper, y)
            if not left > allowed:
                return bool(left <= allowed), y
            fill_row(A, side, v)
            forward_substitute(L, n, v)
            nu[count] = 0.0
        rest = across_active(N, R, count, v, s, z)
        full = left / rest if rest > 0.0 else np.inf
        t, first = raised(nu, s, count, full)
        if t == np.inf:
            return False, y
        if rest > 0.0:
            back_substitute(L, n, z)
            y += t * z
            left -= t * rest
        if first < 0:
            add_row(N, R, count, v)
            left, count = 0.0, count + 1
        else:
            drop_row(N, R, nu, count, first)
            count -= 1
    return False, y


@kernel
def across_active(N: Array, R: Array, count: int, v: Array, s: Array, z: Array) -> float:
    """Fill s with (N Nᵀ)⁻¹ N v and z with v − Nᵀ s; its square, which is zero where N determines v.

    Args:
        N: (n + 1, n) rows of the active limits, the first `count` of it.
        R: (n + 1, n + 1) their factor.
        count: active limits.
        v: (n,) row of a limit.
        s: (n + 1,), overwritten.
        z: (n,), overwritten.
    """
    n, rest, whole = len(v), 0.0, 0.0
    for k in range(count):
        s[k] = 0.0
        for j in range(n):
            s[k] += N[k, j] * v[j]
    forward_substitute(R, count, s)
    back_substitute(R, count, s)
    for j in range(n):
        z[j] = v[j]
    for k in range(count):
        for j in range(n):
            z[j] -= s[k] * N[k, j]
    for j in range(n):
        rest += z[j] * z[j]
        whole += v[j] * v[j]
    return rest if count < n and rest > DEPENDENT * whole else 0.0


@kernel
def raised(nu: Array, s: Array, count: int, full: float) -> tuple[float, int]:
    """Raise the multiplier of the new limit; by how much, and the limit that is dropped then, −1 for none.

    Multipliers of active limits fall by s times as much, the first that would become negative is dropped.

    Args:
        nu: (n + 1,) multipliers, overwritten; the last of them is the new one.
        s: (n + 1,) how the others fall.
        count: active limits.
        full: rise with which the new limit is met.
    """
    t, first = full, -1
    for k in range(count):
        if s[k] > 0.0 and nu[k] < t * s[k]:
            t, first = nu[k] / s[k], k
    for k in range(count):
        nu[k] -= t * s[k]
    nu[count] += t
    return t, first


@kernel
def add_row(N: Array, R: Array, count: int, v: Array) -> None:
    """Add the row of a limit and grow the factor.

    Args:
        N: (n + 1, n) rows of the active limits, overwritten.
        R: (n + 1, n + 1) their factor, overwritten.
        count: active limits before.
        v: (n,) row of the limit.
    """
    column, square = np.zeros(count), 0.0
    for j in range(len(v)):
        N[count, j] = v[j]
        square += v[j] * v[j]
        for k in range(count):
            column[k] += N[k, j] * v[j]
    append_row(R, count, column, square, DEPENDENT * square)


@kernel
def drop_row(N: Array, R: Array, nu: Array, count: int, row: int) -> None:
    """Drop an active limit; the multiplier of the one that is being added moves with the others.

    Args:
        N: (n + 1, n) rows of the active limits, overwritten.
        R: (n + 1, n + 1) their factor, overwritten.
        nu: (n + 1,) multipliers, overwritten.
        count: active limits before.
        row: which.
    """
    delete_row(R, count, row)
    for k in range(row, count):
        nu[k] = nu[k + 1]
        for j in range(N.shape[1]):
            N[k, j] = N[k + 1, j]


@kernel
def exceeded_most(A: Array, lower: Array, upper: Array, y: Array) -> tuple[int, float]:
    """The side of a limit that is exceeded most, and by how much; NaN where y is none.

    Sides are 2 i for the lower and 2 i + 1 for the upper limit i.

    Args:
        A: (m, n).
        lower: (n + m,).
        upper: (n + m,).
        y: (n,).
    """
    side, most, n = 0, 0.0, len(y)
    for i in range(len(lower)):
        value = 0.0
        if i < n:
            value = y[i]
        else:
            for j in range(n):
                value += A[i - n, j] * y[j]
        if not max(lower[i] - value, value - upper[i]) <= most:
            below = lower[i] - value
            side, most = (2 * i, below) if below > 0.0 else (2 * i + 1, value - upper[i])
    return side, most


@kernel
def fill_row(A: Array, side: int, v: Array) -> None:
    """Fill v (n,) with the row of a side of a limit, in the direction that the limit allows.

    Args:
        A: (m, n).
        side: of `exceeded_most`.
        v: (n,), overwritten.
    """
    n, i, sign = len(v), side // 2, 1.0 - 2.0 * (side % 2)
    for j in range(n):
        v[j] = sign * A[i - n, j] if i >= n else 0.0
    if i < n:
        v[i] = sign
