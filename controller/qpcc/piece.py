"""A piece of a QPCC as a small QP, and the way back from its solution.

A piece determines for every mode whether it pushes (w_i = 0, β_i >= 0) or is open (β_i = 0, w_i >= 0). The
equations w_I = 0 give β_I as an affine function of a, so that a QP in a alone remains, n_a variables
instead of n_a + k. Where M_II is singular (duplicate modes), as many β as its rank lacks remain variables,
and the equations that are left over remain rows. M_II is symmetric for robots, but not for bilevel programs
(ex9.2.1 of MacMPEC), which is why an LU factorisation with complete pivoting finds the rank.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tauten.controller.qpcc.elimination import (
    Pushing,
    affine_map,
    eliminate_pushing,
    reduced_objective,
    reduced_rows,
)
from tauten.controller.qpcc.qp import UNBOUNDED
from tauten.controller.qpcc.residuals import (
    ACTIVE,
    EXACT,
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
    kernel,
    solve_transposed,
)

ZERO = 1e-14  # a variable this small is round-off, of a QP whose variables are of order one


class PieceReduction(NamedTuple):
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
) -> tuple[bool, Array, Array, Array, Array, Array, PieceReduction]:
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
    return possible, H, f, A, lower, upper, PieceReduction(tau, price, T, t, source, pushing)


@kernel
def settle_one_cable(problem: Scaled, pushes: Bools, z: Array) -> tuple[bool, Residuals]:
    """Optimum of a piece whose QP has one variable, a parabola over an interval, where it is stationary.

    For a robot of one cable the first piece is nearly always the last one, and no library is called.

    Args:
        problem: scaled.
        pushes: (k,) the modes that push.
        z: (n,) overwritten where the optimum is stationary.

    Returns:
        Whether it is: not when the piece has more variables, is empty or has no minimum; residuals.
    """
    possible, H, f, A, lower, upper, reduction = reduce_piece(problem, pushes)
    y, multipliers = np.zeros(len(f)), np.zeros(len(lower))
    found = possible and len(f) == 1
    if found:
        found = parabola(H[0, 0], f[0], A, lower, upper, y, multipliers)
    point, _, _, values = recover(problem, pushes, reduction, y, multipliers)
    exact = max(values.primal, values.complementarity, values.stationarity) <= EXACT
    if found and exact and values.largest_gain <= ACTIVE:
        z[:] = point
        return True, values
    return False, values


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
def normalise(
    H: Array, f: Array, A: Array, T: Array, lower: Array, upper: Array
) -> tuple[float, float]:
    """Change to y = τ s ŷ, in place, so that H has a unit diagonal and ŷ is of order one.

    Where there is no curvature the objective is divided until its slopes are of order one. T is multiplied
    by s alone. Limits beyond UNBOUNDED remain as they are.

    Args:
        H: (n_y, n_y) Hessian, overwritten.
        f: (n_y,) gradient at zero, overwritten.
        A: (m, n_y) rows, overwritten.
        T: (n, n_y) of `affine_map`, overwritten.
        lower: (n_y + m,) of y and of the rows, overwritten.
        upper: (n_y + m,) likewise, overwritten.

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
    problem: Scaled, pushes: Bools, reduction: PieceReduction, y: Array, multipliers: Array
) -> tuple[Array, Array, Array, Residuals]:
    """Z (n,), multipliers of the bounds (n_a,) and of all rows (2k + p,), residuals from a piece's QP.

    Signs are those of `qp.QpAnswer`: Qz + c + (alpha, 0) + R'dual = 0, positive where an upper limit
    holds.

    Args:
        problem: scaled.
        pushes: (k,) the modes that push.
        reduction: of `reduce_piece`.
        y: (n_y,) solution of the piece's QP.
        multipliers: (n_y + m,) of the QP, of the bounds on y and of its rows.
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
    """Complete `dual`: equations w_I = 0 from the columns of β_I, then β_J = 0 from their own.

    Args:
        problem: scaled.
        pushes: (k,) the modes that push.
        pushing: the eliminated modes.
        z: (n,) the point, scaled.
        dual: (2k + p,) multipliers of the rows, completed in place.
    """
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
