"""The objective and rows of a piece after the elimination of the modes that push."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tauten.controller.qpcc.qp import UNBOUNDED
from tauten.controller.qpcc.residuals import FLOOR
from tauten.controller.qpcc.scaling import Scaled, largest_magnitude
from tauten.model.numerics import Array, Bools, Ints, eliminate, kernel, solve_upper

# coefficients this small, relative to the terms they are summed from, are round-off
CONSTANT = 1e-9


class Pushing(NamedTuple):
    """The modes that push, eliminated: E = L U of M_II in the order of the pivots.

    Attributes:
        rank: of M_II.
        rows: (p,) modes in the order of the pivots' rows; from `rank` on, w is not eliminated.
        cols: (p,) modes in the order of the pivots' columns; from `rank` on, β remains a variable.
        E: (p, p) factors.
        beta: (p, n_a + p - rank + 1) row s < rank: β_cols[s] in terms of (a, remaining β, 1).
    """

    rank: int
    rows: Ints
    cols: Ints
    E: Array
    beta: Array


@kernel
def eliminate_pushing(problem: Scaled, modes: Ints) -> Pushing:
    """Solve w_I = 0 for as many β_I as M_II has rank."""
    n_a, p = len(problem.lb), len(modes)
    k = len(problem.c) - n_a
    E, X = np.empty((p, p)), np.empty((p, n_a + 1))
    for i in range(p):
        row = k + modes[i]
        for j in range(p):
            E[i, j] = problem.R[row, n_a + modes[j]]
        for j in range(n_a):
            X[i, j] = -problem.R[row, j]
        X[i, n_a] = -problem.r[row]
    rank, rows, cols = eliminate(E, X)
    free = p - rank
    beta = np.zeros((p, n_a + free + 1))
    for i in range(rank):
        beta[i, :n_a] = X[i, :n_a]
        beta[i, n_a + free] = X[i, n_a]
        for j in range(free):
            beta[i, n_a + j] = -E[i, rank + j]
    solve_upper(E, beta, rank)
    return Pushing(rank, modes[rows], modes[cols], E, beta)


@kernel
def affine_map(pushing: Pushing, n_a: int, k: int) -> tuple[Array, Array, Ints]:
    """T, t of z = T y + t, and which z are not fixed at zero."""
    rank, cols = pushing.rank, pushing.cols
    free = len(cols) - rank
    T, t = np.zeros((n_a + k, n_a + free)), np.zeros(n_a + k)
    for j in range(n_a):
        T[j, j] = 1.0
    for j in range(free):
        T[n_a + cols[rank + j], n_a + j] = 1.0
    for s in range(rank):
        T[n_a + cols[s]] = pushing.beta[s, : n_a + free]
        t[n_a + cols[s]] = pushing.beta[s, n_a + free]
    return T, t, np.concatenate((np.arange(n_a), n_a + cols))


@kernel
def reduced_objective(problem: Scaled, T: Array, t: Array, live: Ints) -> tuple[Array, Array]:
    """T'QT and T'(Qt + c), summed over the `live` variables only.

    Args:
        problem: scaled.
        T: (n, n_y) of `affine_map`.
        t: (n,) of `affine_map`.
        live: indices of the variables that are not fixed at zero.
    """
    Q, n_y, p = problem.Q, T.shape[1], len(live)
    QT, q = np.zeros((p, n_y)), np.empty(p)
    for r in range(p):
        q[r] = problem.c[live[r]]
        for s in range(p):
            value = Q[live[r], live[s]]
            q[r] += value * t[live[s]]
            for j in range(n_y):
                QT[r, j] += value * T[live[s], j]
    H, f = np.zeros((n_y, n_y)), np.zeros(n_y)
    for r in range(p):
        for i in range(n_y):
            value = T[live[r], i]
            f[i] += value * q[r]
            for j in range(i + 1):
                H[i, j] += value * QT[r, j]
    for i in range(n_y):
        for j in range(i):
            H[j, i] = H[i, j]
    return H, f


@kernel
def reduced_rows(
    problem: Scaled, pushing: Pushing, pushes: Bools, T: Array, t: Array, live: Ints
) -> tuple[bool, Array, Array, Array, Ints]:
    """Rows (4) in terms of y: A, low, high, and which row of R each one is.

    A row that does not depend on y is left out when it holds; when it does not, the piece is empty,
    and the first value is False.

    Args:
        problem: scaled.
        pushing: the eliminated modes.
        pushes: (k,) the modes that push.
        T: (n, n_y) of `affine_map`.
        t: (n,) of `affine_map`.
        live: indices of the variables that are not fixed at zero.
    """
    k, rank = len(pushes), pushing.rank
    kept = np.ones(len(problem.r), dtype=np.bool_)
    kept[:k] = False
    for s in range(rank):
        kept[pushing.cols[s]] = True
        kept[k + pushing.rows[s]] = False
    most = int(np.sum(kept))
    A, low, high = np.zeros((most, T.shape[1])), np.empty(most), np.empty(most)
    source, count, possible = np.empty(most, dtype=np.int64), 0, True
    reach = FLOOR * largest_magnitude(t)
    for i in np.flatnonzero(kept):
        A[count] = 0.0
        constant, size, depends = reduced_row(problem.R[i], problem.r[i], T, t, live, A[count])
        lo, hi = problem.lo[i], problem.hi[i]
        if k <= i < 2 * k and pushes[i - k]:
            hi = lo
        if depends:
            low[count] = lo - constant if lo > -UNBOUNDED else lo
            high[count] = hi - constant if hi < UNBOUNDED else hi
            source[count] = i
            count += 1
        else:
            slack = CONSTANT * max(size + min(abs(lo), abs(hi)), reach)
            possible = possible and lo - slack <= constant <= hi + slack
    return possible, A[:count], low[:count], high[:count], source[:count]


@kernel
def reduced_row(
    row: Array, constant: float, T: Array, t: Array, live: Ints, out: Array
) -> tuple[float, float, bool]:
    """Row z + constant in terms of y: writes the coefficients to `out`.

    Args:
        row: (n,) a row of R.
        constant: its entry of r.
        T: (n, n_y) of `affine_map`.
        t: (n,) of `affine_map`.
        live: indices of the variables that are not fixed at zero.
        out: (n_y,) zeros, overwritten with the coefficients.

    Returns:
        Its constant, the magnitude of the constant's terms, and whether it depends on y at all:
        coefficients far below the terms they are summed from are round-off.
    """
    size, largest = abs(constant), 0.0
    for s in range(len(live)):
        value = row[live[s]]
        if value != 0.0:
            constant += value * t[live[s]]
            size += abs(value * t[live[s]])
            for j in range(len(out)):
                term = value * T[live[s], j]
                out[j] += term
                largest = max(largest, abs(term))
    depends = False
    for j in range(len(out)):
        depends = depends or abs(out[j]) > CONSTANT * largest
    return constant, size, depends
