"""The active-set method of `tauten.model.numerics.lcp.solve_lcp`.

    min ½ λᵀ (W + ρ diag W) λ + δ_freeᵀ λ   over λ ≥ 0                                  (T3)

is non-negative least squares in Gram form, solved by the primal active set of Lawson and Hanson
(1974) in the form of Bro and de Jong (1997). The set F contains the rows with a force. In each iteration
the row with the most negative gap is added to F and the forces that close the gaps of F are computed; rows
whose force would become negative on the way to them are removed. The objective decreases in every iteration,
so that no F occurs twice. The size of F is about the rank of W, and F changes by single rows, so that its
Cholesky factor is updated. (Block principal pivoting cycles on these nearly singular problems; projected
Newton needs as many iterations with a factorisation each.)

Internally, rows are scaled by s_i = 1/√w_ii, which makes the diagonal 1 + ρ.
"""

from __future__ import annotations

import numpy as np

from tauten.model.numerics.arrays import Array, Bools, Ints
from tauten.model.numerics.jit import kernel
from tauten.model.numerics.updated_cholesky import (
    append_row,
    back_substitute,
    delete_row,
    forward_substitute,
)

POLISHING = 2  # proximal steps at the end
IMMOVABLE = 1e-14  # a compliance this far below the largest is rounding: no force moves that row


@kernel
def active_set_forces(
    W: Array, delta_free: Array, start: Array, rho: float, max_iterations: int
) -> tuple[Array, int]:
    """Forces (m,) that minimise (T3), polished, and how many sets were tried.

    Args:
        W: (m, m) compliance [m/N].
        delta_free: (m,) gaps without forces [m].
        start: (m,) forces to start from; entries that are not positive are ignored.
        rho: regularisation, at least about 1e-13.
        max_iterations: sets at most.
    """
    n = delta_free.shape[0]
    s = row_scales(W)
    # below the effect of rho on gaps
    threshold = 1e-3 * rho * np.abs(delta_free).max() if n > 0 else 0.0
    lam = np.zeros(n)
    L, F = np.empty((min(n, 64), min(n, 64))), np.empty(n, np.int64)
    f = 0
    inside = np.zeros(n, np.bool_)
    excluded = np.zeros(n, np.bool_)  # removed as soon as they were added: their gap is rounding
    for i in range(n):
        if start[i] > 0.0 and s[i] > 0.0:
            lam[i] = start[i]
            L = join(W, s, rho, L, F, f, i)
            inside[i] = True
            f += 1
    newest = -1
    for iteration in range(max_iterations):
        if iteration > 0 or f == 0:
            newest = most_negative_gap(W, delta_free, lam, F[:f], inside, excluded, s, -threshold)
            if newest < 0:
                polish(W, delta_free, s, L, F, f, lam)
                return lam, iteration
            L = join(W, s, rho, L, F, f, newest)
            inside[newest] = True
            f += 1
        f = solve_on_set(delta_free, s, L, F, f, lam, inside)
        if newest >= 0:
            if inside[newest]:
                excluded[:] = False
            else:
                excluded[newest] = True
    return lam, max_iterations


@kernel
def row_scales(W: Array) -> Array:
    """The scales s_i = 1/√w_ii (m,), zero where no force moves the row."""
    n = W.shape[0]
    largest = 0.0
    for i in range(n):
        largest = max(largest, W[i, i])
    s = np.zeros(n)
    for i in range(n):
        if W[i, i] > IMMOVABLE * largest:
            s[i] = 1.0 / np.sqrt(W[i, i])
    return s


@kernel
def gaps(W: Array, delta_free: Array, lam: Array, F: Ints) -> Array:
    """Gaps δ_free + W λ of all rows (m,) under forces on the rows F.

    Args:
        W: (m, m) compliance.
        delta_free: (m,) gaps without force.
        lam: (m,) forces, used on F only.
        F: (f,) rows with force.
    """
    delta = delta_free.copy()
    for i in F:
        delta += lam[i] * W[i]
    return delta


@kernel
def most_negative_gap(
    W: Array, delta_free: Array, lam: Array, F: Ints, inside: Bools, excluded: Bools, s: Array,
    threshold: float,
) -> int:  # fmt: skip
    """The row outside F with the most negative gap below `threshold`, −1 without one.

    Args:
        W: (m, m) compliance [m/N].
        delta_free: (m,) gaps without forces [m].
        lam: (m,) forces [N].
        F: (f,) rows with a force.
        inside: (m,) whether a row is in F.
        excluded: (m,) rows that are not to be added.
        s: (m,) scales of the rows.
        threshold: [m].
    """
    delta = gaps(W, delta_free, lam, F)
    row, least = -1, threshold
    for i in range(delta.shape[0]):
        if delta[i] < least and not inside[i] and not excluded[i] and s[i] > 0.0:
            row, least = i, delta[i]
    return row


@kernel
def join(W: Array, s: Array, rho: float, L: Array, F: Ints, f: int, row: int) -> Array:
    """Add a row to F and its factor; returns the factor, in a larger array where the old one was full.

    Args:
        W: (m, m) compliance.
        s: (m,) scales of the rows.
        rho: regularisation ρ.
        L: array that begins with the Cholesky factor of F.
        F: rows with force, the first f of it; overwritten.
        f: |F|.
        row: the row to add.
    """
    if f == L.shape[0]:
        larger = np.empty((2 * f, 2 * f))
        larger[:f, :f] = L
        L = larger
    column = np.empty(f)
    for k in range(f):
        column[k] = W[row, F[k]] * s[row] * s[F[k]]
    append_row(L, f, column, 1.0 + rho, rho)
    F[f] = row
    return L


@kernel
def solve_on_set(
    delta_free: Array, s: Array, L: Array, F: Ints, f: int, lam: Array, inside: Bools
) -> int:
    """Set lam to the forces that close the gaps of F, without rows whose force is negative. Returns |F|.

    Args:
        delta_free: (m,) gaps without force.
        s: (m,) scales of the rows.
        L: array that begins with the Cholesky factor of F, overwritten.
        F: rows with force, the first f of it; overwritten.
        f: |F|.
        lam: (m,) forces, overwritten.
        inside: (m,) whether a row is in F, overwritten.
    """
    while f > 0:
        y = np.empty(f)
        for k in range(f):
            y[k] = -delta_free[F[k]] * s[F[k]]
        forward_substitute(L, f, y)
        back_substitute(L, f, y)
        share, blocking = 1.0, -1  # largest step towards y at which all forces are positive
        for k in range(f):
            y[k] *= s[F[k]]
            if y[k] <= 0.0:
                here = lam[F[k]] / (lam[F[k]] - y[k]) if lam[F[k]] > 0.0 else 0.0
                if here < share:
                    share, blocking = here, k
        for k in range(f):
            lam[F[k]] += share * (y[k] - lam[F[k]])
        if blocking < 0:
            return f
        lam[F[blocking]] = 0.0
        for k in range(f - 1, -1, -1):
            if lam[F[k]] <= 0.0:
                lam[F[k]], inside[F[k]] = 0.0, False
                delete_row(L, f, k)
                F[k : f - 1] = F[k + 1 : f].copy()
                f -= 1
    return f


@kernel
def polish(W: Array, delta_free: Array, s: Array, L: Array, F: Ints, f: int, lam: Array) -> None:
    """Close the gaps ρ w_ii λ_i that the regularisation leaves on F, as far as no force becomes negative.

    Proximal steps with the factor of F: each multiplies the error of the eigenvalue σ of the scaled
    compliance by ρ / (σ + ρ).

    Args:
        W: (m, m) compliance.
        delta_free: (m,) gaps without force.
        s: (m,) scales of the rows.
        L: array that begins with the Cholesky factor of F.
        F: rows with force, the first f of it.
        f: |F|.
        lam: (m,) forces, overwritten.
    """
    for _ in range(POLISHING):
        delta = gaps(W, delta_free, lam, F[:f])
        y = np.empty(f)
        for k in range(f):
            y[k] = -delta[F[k]] * s[F[k]]
        forward_substitute(L, f, y)
        back_substitute(L, f, y)
        share = 1.0
        for k in range(f):
            y[k] *= s[F[k]]
            if lam[F[k]] + share * y[k] < 0.0:
                share = -lam[F[k]] / y[k]
        for k in range(f):
            lam[F[k]] = max(0.0, lam[F[k]] + share * y[k])
