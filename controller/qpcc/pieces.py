"""A piece of a QPCC as a small QP.

A piece says of every mode whether it pushes (w_i = 0, β_i >= 0) or is open (β_i = 0, w_i >= 0). The
equations w_I = 0 give β_I as an affine function of a, so that a QP in a alone is left, n_a variables
instead of n_a + k. Where M_II is singular (duplicate modes), as many β as it lacks in rank stay
variables, and the equations left over stay rows.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tauten.controller.qpcc.elimination import back_substitute, eliminate
from tauten.controller.qpcc.qp import UNBOUNDED
from tauten.controller.qpcc.scaling import Scaled
from tauten.model.numerics import Array, Bools, Ints, kernel

CONSTANT = 1e-9  # a row whose coefficients are this small beside their terms does not depend on y
SLACK = 1e-9  # how far such a row may lie outside its limits, relative to its terms


class Pushing(NamedTuple):
    """The modes that push, eliminated: E = L U of M_II in the order of the pivots.

    Attributes:
        rank: of M_II.
        rows: (p,) modes in the order of the pivots' rows; from `rank` on, w is not eliminated.
        cols: (p,) modes in the order of the pivots' columns; from `rank` on, β stays a variable.
        E: (p, p) factors.
        beta: (p, n_a + p - rank + 1) row s < rank: β_cols[s] in terms of (a, β that stay, 1).
    """

    rank: int
    rows: Ints
    cols: Ints
    E: Array
    beta: Array


class Reduction(NamedTuple):
    """z = τ T y + t, y = (a, β that stay) of order one.

    Attributes:
        tau: scale.
        T: (n, n_y).
        t: (n,).
        source: (rows,) which row of R each row of the QP is.
        pushing: what was eliminated.
    """

    tau: float
    T: Array
    t: Array
    source: Ints
    pushing: Pushing


@kernel
def eliminate_pushing(M: Array, m: Array, modes: Ints, n_a: int) -> Pushing:
    """Solve w_I = 0 for as many β_I as M_II has rank."""
    p = len(modes)
    E, X = np.empty((p, p)), np.empty((p, n_a + 1))
    for i in range(p):
        for j in range(p):
            E[i, j] = M[modes[i], n_a + modes[j]]
        for j in range(n_a):
            X[i, j] = -M[modes[i], j]
        X[i, n_a] = -m[modes[i]]
    rank, rows, cols = eliminate(E, X)
    free = p - rank
    beta = np.zeros((p, n_a + free + 1))
    for i in range(rank):
        beta[i, :n_a] = X[i, :n_a]
        beta[i, n_a + free] = X[i, n_a]
        for j in range(free):
            beta[i, n_a + j] = -E[i, rank + j]
    back_substitute(E, beta, rank)
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
    """T'QT and T'(Qt + c), summed over the `live` variables only."""
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
def reduced_row(
    row: Array, constant: float, T: Array, t: Array, live: Ints, out: Array
) -> tuple[float, float, bool]:
    """Row z + constant in terms of y: writes the coefficients to `out`.

    Returns:
        Its constant, the magnitude of the constant's terms, and whether it depends on y at all:
        what is left far below the terms it was summed from is round-off.
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


@kernel
def rows_in_play(pushing: Pushing, pushes: Bools, rows: int) -> tuple[Bools, Bools]:
    """Which rows of R the piece's QP has, and which of them are equations."""
    k, rank = len(pushes), pushing.rank
    kept, fixed = np.ones(rows, dtype=np.bool_), np.zeros(rows, dtype=np.bool_)
    kept[:k] = False
    for s in range(rank):
        kept[pushing.cols[s]] = True
        kept[k + pushing.rows[s]] = False
    fixed[k : 2 * k] = pushes
    return kept, fixed


@kernel
def reduced_rows(
    problem: Scaled, pushing: Pushing, pushes: Bools, T: Array, t: Array, live: Ints
) -> tuple[bool, Array, Array, Array, Ints]:
    """Rows (4) in terms of y: A, low, high, and which row of R each one is.

    A row that does not depend on y is left out when it holds; when it does not, the piece is empty,
    and the first value is False.
    """
    kept, fixed = rows_in_play(pushing, pushes, len(problem.r))
    most = int(np.sum(kept))
    A, low, high = np.zeros((most, T.shape[1])), np.empty(most), np.empty(most)
    source, count, possible = np.empty(most, dtype=np.int64), 0, True
    for i in np.flatnonzero(kept):
        A[count] = 0.0
        constant, size, depends = reduced_row(problem.R[i], problem.r[i], T, t, live, A[count])
        lo = problem.lo[i]
        hi = lo if fixed[i] else problem.hi[i]
        if depends:
            low[count] = lo - constant
            high[count] = hi - constant
            source[count] = i
            count += 1
        else:
            slack = SLACK * (size + min(abs(lo), abs(hi)))
            possible = possible and lo - slack <= constant <= hi + slack
    return possible, A[:count], low[:count], high[:count], source[:count]


@kernel
def normalise(H: Array, f: Array, A: Array, T: Array, lower: Array, upper: Array) -> float:
    """Change to y = τ s ŷ, in place, so that H has a unit diagonal and ŷ is of order one.

    T is multiplied by s alone. Returns τ.
    """
    n_y = len(f)
    largest, tau = 0.0, 0.0
    for j in range(n_y):
        largest = max(largest, H[j, j])
    for j in range(n_y):
        s = 1.0 / np.sqrt(H[j, j]) if H[j, j] > 1e-14 * largest else 1.0
        f[j] *= s
        H[j, :] *= s
        H[:, j] *= s
        A[:, j] *= s
        T[:, j] *= s
        lower[j] /= s
        upper[j] /= s
        tau = max(tau, abs(f[j]), lower[j], -upper[j])
    for i in range(len(A)):
        norm = np.sqrt(np.sum(A[i] ** 2))
        if norm > 0.0:
            tau = max(tau, lower[n_y + i] / norm, -upper[n_y + i] / norm)
    if not (0.0 < tau < UNBOUNDED):
        tau = 1.0
    f /= tau
    for i in range(len(lower)):
        lower[i] = min(max(lower[i] / tau, -UNBOUNDED), UNBOUNDED)
        upper[i] = min(max(upper[i] / tau, -UNBOUNDED), UNBOUNDED)
    return tau


@kernel
def reduce_piece(
    problem: Scaled, pushes: Bools
) -> tuple[bool, Array, Array, Array, Array, Array, Reduction]:
    """The QP of a piece and the way back to z.

    Returns:
        Whether it can have a point; H, f, A, lower, upper as in `qp.Qp`; what `recover` needs.
    """
    n_a, k = len(problem.lb), len(pushes)
    M, m = problem.R[k : 2 * k], problem.r[k : 2 * k]
    pushing = eliminate_pushing(M, m, np.flatnonzero(pushes), n_a)
    T, t, live = affine_map(pushing, n_a, k)
    H, f = reduced_objective(problem, T, t, live)
    possible, A, low, high, source = reduced_rows(problem, pushing, pushes, T, t, live)
    free = T.shape[1] - n_a
    lower = np.concatenate((problem.lb, np.zeros(free), low))
    upper = np.concatenate((problem.ub, np.full(free, UNBOUNDED), high))
    tau = normalise(H, f, A, T, lower, upper)
    return possible, H, f, A, lower, upper, Reduction(tau, T, t, source, pushing)
