"""A piece of a QPCC as a small QP, and the way back from its solution.

A piece says of every mode whether it pushes (w_i = 0, β_i >= 0) or is open (β_i = 0, w_i >= 0). The
equations w_I = 0 give β_I as an affine function of a, so that a QP in a alone remains, n_a variables
instead of n_a + k. Where M_II is singular (duplicate modes), as many β as its rank lacks remain variables,
and the equations that are left over remain rows. M_II is symmetric for robots, but not for bilevel programs
(ex9.2.1 of MacMPEC), which is why an LU factorisation with complete pivoting finds the rank.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tauten.controller.qpcc.qp import UNBOUNDED
from tauten.controller.qpcc.residuals import (
    EXACT,
    FLOOR,
    Residuals,
    add_multipliers,
    gradient,
    residuals,
)
from tauten.controller.qpcc.scaling import Scaled, largest_magnitude
from tauten.model.numerics import (
    Array,
    Bools,
    Ints,
    eliminate,
    kernel,
    solve_transposed,
    solve_upper,
)

CONSTANT = (
    1e-9  # coefficients this small, relative to the terms they are summed from, are round-off
)
ZERO = 1e-14  # as is a variable this small, of a QP whose variables are of order one


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


class Reduction(NamedTuple):
    """z = τ T y + t, y = (a, remaining β) of order one.

    Attributes:
        tau: scale.
        price: factor from the QP's multipliers to those of the piece.
        T: (n, n_y).
        t: (n,).
        source: (rows,) which row of R each row of the QP is.
        pushing: the modes that were eliminated.
    """

    tau: float
    price: float
    T: Array
    t: Array
    source: Ints
    pushing: Pushing


@kernel
def reduce_piece(
    problem: Scaled, pushes: Bools
) -> tuple[bool, Array, Array, Array, Array, Array, Reduction]:
    """The QP of a piece and the way back to z.

    Returns:
        Whether it can have a point; H, f, A, lower, upper as in `qp.Qp`; what `recover` needs.
    """
    n_a, k = len(problem.lb), len(pushes)
    pushing = eliminate_pushing(problem, np.flatnonzero(pushes))
    T, t, live = affine_map(pushing, n_a, k)
    H, f = reduced_objective(problem, T, t, live)
    possible, A, low, high, source = reduced_rows(problem, pushing, pushes, T, t, live)
    free = T.shape[1] - n_a
    lower = np.concatenate((problem.lb, np.zeros(free), low))
    upper = np.concatenate((problem.ub, np.full(free, UNBOUNDED), high))
    tau, price = normalise(H, f, A, T, lower, upper)
    return possible, H, f, A, lower, upper, Reduction(tau, price, T, t, source, pushing)


@kernel
def solve_one_cable(problem: Scaled, pushes: Bools) -> tuple[bool, Array, Array, Array, Residuals]:
    """Optimum of a piece whose QP has one variable, a parabola over an interval.

    For a robot of one cable this is nearly every piece; one pass from the problem to the point takes two
    thirds of the time of a library's call (recorded problems of the finger).

    Returns:
        Whether it was found: not when the piece has more variables, is empty or has no minimum; z,
        multipliers and residuals as of `recover`.
    """
    possible, H, f, A, lower, upper, reduction = reduce_piece(problem, pushes)
    y, multipliers = np.zeros(len(f)), np.zeros(len(lower))
    found = possible and len(f) == 1
    if found:
        found = parabola(H[0, 0], f[0], A, lower, upper, y, multipliers)
    return found, *recover(problem, pushes, reduction, y, multipliers)


@kernel
def parabola(
    H: float, f: float, A: Array, lower: Array, upper: Array, y: Array, multipliers: Array
) -> bool:
    """Solve `qp.Qp` with one variable; False when nothing satisfies the limits or there is no minimum.

    Args:
        H: at least zero.
        f: slope at zero.
        A: (m, 1), no zeros.
        lower: (1 + m,).
        upper: (1 + m,).
        y: (1,) the solution, overwritten.
        multipliers: (1 + m,) zeros; that of the limit which holds is overwritten, as in `qp.QpAnswer`.
    """
    low, high, at_low, at_high = lower[0], upper[0], 0, 0
    for i in range(len(A)):
        one, other = lower[1 + i] / A[i, 0], upper[1 + i] / A[i, 0]
        if min(one, other) > low:
            low, at_low = min(one, other), 1 + i
        if max(one, other) < high:
            high, at_high = max(one, other), 1 + i
    free = -f / H if H > 0.0 else -np.sign(f) * UNBOUNDED
    y[0] = min(max(free, low), high)
    if not (low <= high and abs(y[0]) < UNBOUNDED):
        return False
    if y[0] != free:
        holds = at_low if free < low else at_high
        multipliers[holds] = -(H * y[0] + f) / (A[holds - 1, 0] if holds > 0 else 1.0)
    return True


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
def reduced_rows(
    problem: Scaled, pushing: Pushing, pushes: Bools, T: Array, t: Array, live: Ints
) -> tuple[bool, Array, Array, Array, Ints]:
    """Rows (4) in terms of y: A, low, high, and which row of R each one is.

    A row that does not depend on y is left out when it holds; when it does not, the piece is empty,
    and the first value is False.
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


@kernel
def normalise(
    H: Array, f: Array, A: Array, T: Array, lower: Array, upper: Array
) -> tuple[float, float]:
    """Change to y = τ s ŷ, in place, so that H has a unit diagonal and ŷ is of order one.

    Where there is no curvature the objective is divided until its slopes are of order one. T is multiplied
    by s alone. Limits beyond UNBOUNDED remain as they are.

    Returns:
        τ and the factor from the multipliers of the new QP to those of the old one.
    """
    n_y = len(f)
    tau, least = 0.0, 1e-14 * largest_magnitude(np.diag(H))
    for j in range(n_y):
        curved = H[j, j] > least
        s = 1.0 / np.sqrt(H[j, j]) if curved else 1.0
        f[j] *= s
        H[j, :] *= s
        H[:, j] *= s
        A[:, j] *= s
        T[:, j] *= s
        lower[j], upper[j] = divided(lower[j], s), divided(upper[j], s)
        tau = max(tau, lower[j], -upper[j])
        if curved:
            tau = max(tau, abs(f[j]))
    for i in range(len(A)):
        norm = np.sqrt(np.sum(A[i] ** 2))
        if norm > 0.0:
            tau = max(tau, lower[n_y + i] / norm, -upper[n_y + i] / norm)
    if not (0.0 < tau < UNBOUNDED):
        tau = 1.0
    f /= tau
    for i in range(len(lower)):
        lower[i], upper[i] = divided(lower[i], tau), divided(upper[i], tau)
    cost = max(largest_magnitude(f), 1.0)
    if cost > 1.0:
        H /= cost
        f /= cost
    return tau, tau * cost


@kernel
def divided(limit: float, size: float) -> float:
    """A limit in another unit, within ±UNBOUNDED, beyond which there is none."""
    if abs(limit) >= UNBOUNDED:
        return limit
    return min(max(limit / size, -UNBOUNDED), UNBOUNDED)


@kernel
def recover(
    problem: Scaled, pushes: Bools, reduction: Reduction, y: Array, multipliers: Array
) -> tuple[Array, Array, Array, Residuals]:
    """Z (n,), multipliers of the bounds (n_a,) and of all rows (2k + p,), residuals from a piece's QP.

    Signs are those of `qp.QpAnswer`: Qz + c + (alpha, 0) + R'dual = 0, positive where an upper limit
    holds.
    """
    n_a, k = len(problem.lb), len(pushes)
    tau, price, T = reduction.tau, reduction.price, reduction.T
    cols, rank = reduction.pushing.cols, reduction.pushing.rank
    z = reduction.t.copy()
    for j in range(len(y)):
        if abs(y[j]) > ZERO:
            for i in range(len(z)):
                z[i] += tau * T[i, j] * y[j]
    alpha, dual = np.zeros(n_a), np.zeros(len(problem.r))
    for j in range(n_a):
        alpha[j] = price * multipliers[j] / T[j, j]
        z[j] = min(max(z[j], problem.lb[j]), problem.ub[j])
        if (
            alpha[j] != 0.0
        ):  # exactly at the bound, but for libraries whose multipliers are never zero
            bound = problem.ub[j] if alpha[j] > 0.0 else problem.lb[j]
            z[j] = bound if abs(z[j] - bound) <= EXACT * tau * T[j, j] else z[j]
    for i in range(k):
        z[n_a + i] = max(z[n_a + i], 0.0) if pushes[i] else 0.0
    for j in range(n_a, len(y)):
        i = cols[rank + j - n_a]
        dual[i] = price * multipliers[j] / T[n_a + i, j]
    for i in range(len(reduction.source)):
        dual[reduction.source[i]] = price * multipliers[len(y) + i]
    eliminated_multipliers(problem, pushes, reduction.pushing, z, dual)
    return z, alpha, dual, residuals(problem, z, alpha, dual)


@kernel
def eliminated_multipliers(
    problem: Scaled, pushes: Bools, pushing: Pushing, z: Array, dual: Array
) -> None:
    """Complete `dual`: equations w_I = 0 from the columns of β_I, then β_J = 0 from their own."""
    n_a, k, rank = len(problem.lb), len(pushes), pushing.rank
    g, _ = gradient(problem, z)  # (n,)
    add_multipliers(problem, np.zeros(n_a), dual, g)
    x = np.empty(rank)
    for s in range(rank):
        x[s] = -g[n_a + pushing.cols[s]]
    solve_transposed(pushing.E, x, rank)
    for s in range(rank):
        i = k + pushing.rows[s]
        dual[i] += x[s]
        for j in range(len(g)):
            g[j] += x[s] * problem.R[i, j]
    for i in range(k):
        if not pushes[i]:  # row i of R is that of β_i alone
            dual[i] -= g[n_a + i]
