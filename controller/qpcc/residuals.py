"""Residuals of a point and its multipliers, from the problem alone, whichever solver found them.

A residual is relative to the terms that it is the sum of, so that neither units nor the size of the
problem matter. Two things bound those terms from below, because a sum of nothing but round-off has no
relative accuracy: a constraint row counts at least FLOOR of the largest variable times the row's largest
coefficient, and FLOOR of the distance of its limits (an actuator that rests at a limit of zero has no other
term); an entry of the gradient counts at least FLOOR of its largest entry. The terms of the gradient are
those of the objective alone: large multipliers, which cancel each other, must not hide a slope.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tauten.controller.qpcc.problem import Qpcc
from tauten.controller.qpcc.qp import UNBOUNDED
from tauten.controller.qpcc.scaling import USABLE, Scaled, largest_magnitude, scale
from tauten.controller.qpcc.solution import Certificate
from tauten.model.numerics import Array, Bools, Ints, active_set_forces, kernel

# Relative residual of a solution; double precision leaves 1e-16 times the conditioning
EXACT = 1e-8
ACTIVE = 1e-8  # a limit this close, relative to its terms, may carry a multiplier
# Share of the largest terms that terms count at least; 1e-11 of a force is then round-off
FLOOR = 1e-3
RIDGE = 1e-12  # of the unit diagonal of the multipliers' least squares problem, where they are not unique
PUSHES, OPEN, EITHER = 1, -1, 0  # side of a pair of which β and w are both zero


class Residuals(NamedTuple):
    """Objective and residuals of a point.

    Attributes:
        objective: without the constant.
        terms: sum of the magnitudes of the objective's terms.
        primal: largest violation of bounds, limits and signs, relative.
        complementarity: largest smaller side of a pair, relative.
        stationarity: largest entry of the Lagrangian's gradient, relative.
        gain: (k,) how fast the objective falls, relative, when the side of a pair that the piece holds at
            zero is released; above zero only where both sides are zero.
        largest_gain: of them.
    """

    objective: float
    terms: float
    primal: float
    complementarity: float
    stationarity: float
    gain: Array
    largest_gain: float


@kernel
def row_values(problem: Scaled, z: Array) -> tuple[Array, Array]:
    """R z + r and the magnitude of its terms: (rows,), (rows,)."""
    R, n_a = problem.R, len(problem.lb)
    k = len(z) - n_a
    values, sizes = problem.r.copy(), np.abs(problem.r)
    floor = FLOOR * largest_magnitude(z)
    for i in range(k):  # the rows of β
        values[i], sizes[i] = z[n_a + i], max(abs(z[n_a + i]), floor)
    for i in range(k, len(values)):
        largest = 0.0
        for j in range(len(z)):
            if R[i, j] != 0.0:
                term = R[i, j] * z[j]
                values[i] += term
                sizes[i] += abs(term)
                largest = max(largest, abs(R[i, j]))
        span = problem.hi[i] - problem.lo[i]
        sizes[i] = max(sizes[i], floor * largest, FLOOR * span if span < UNBOUNDED else 0.0)
    return values, sizes


@kernel
def pair_values(problem: Scaled, z: Array, values: Array, sizes: Array) -> tuple[Array, Array]:
    """β and w of every pair, both relative to the terms of w: (k,), (k,).

    Args:
        problem: scaled.
        z: (n,) the point, scaled.
        values: (2k + p,) of `row_values`.
        sizes: (2k + p,) of `row_values`.
    """
    n_a = len(problem.lb)
    k = len(z) - n_a
    beta, w = np.zeros(k), np.zeros(k)
    for i in range(k):
        weight = pair_weight(problem, i)
        size = max(sizes[k + i], abs(weight * z[n_a + i]))
        if size > 0.0:
            beta[i] = weight * z[n_a + i] / size
            w[i] = values[k + i] / size
    return beta, w


@kernel
def pair_weight(problem: Scaled, i: int) -> float:
    """How far a unit of β_i moves w_i, to compare the two."""
    n_a = len(problem.lb)
    k = len(problem.c) - n_a
    weight = float(abs(problem.R[k + i, n_a + i]))
    if weight == 0.0:
        weight = largest_magnitude(problem.R[k + i])
    return weight


@kernel
def limit_residual(problem: Scaled, z: Array, values: Array, sizes: Array) -> float:
    """Largest violation of bounds and limits, relative.

    Args:
        problem: scaled.
        z: (n,) the point, scaled.
        values: (2k + p,) of `row_values`.
        sizes: (2k + p,) of `row_values`.
    """
    n_a = len(problem.lb)
    worst = 0.0
    for j in range(n_a):
        excess = max(problem.lb[j] - z[j], z[j] - problem.ub[j])
        if excess > 0.0:
            worst = max(worst, excess / (excess + abs(z[j])))
    for i in range(2 * (len(z) - n_a), len(values)):
        excess = max(problem.lo[i] - values[i], values[i] - problem.hi[i])
        if excess > 0.0:
            worst = max(worst, excess / (excess + sizes[i]))
    return worst


@kernel
def signs_allowed(
    problem: Scaled, z: Array, values: Array, sizes: Array, beta: Array, w: Array, sides: Ints
) -> tuple[Bools, Bools]:
    """Which multipliers a stationary point may have: (n_a + rows, 2) bool, and pairs with both sides zero.

    Args:
        problem: scaled.
        z: (n,) the point.
        values: (rows,) of `row_values`.
        sizes: (rows,) of `row_values`.
        beta: (k,) of `pair_values`.
        w: (k,) of `pair_values`.
        sides: (k,) PUSHES, OPEN or EITHER, read where both sides of a pair are zero. EITHER allows what
            strong stationarity does.

    Returns:
        Columns: positive (the upper limit holds), negative (the lower one); and (k,) bool.
    """
    n_a = len(problem.lb)
    k = len(z) - n_a
    allowed = np.zeros((n_a + len(values), 2), dtype=np.bool_)
    both = np.zeros(k, dtype=np.bool_)
    for j in range(n_a):
        allowed[j, 0], allowed[j, 1] = z[j] >= problem.ub[j], z[j] <= problem.lb[j]
    for i in range(2 * k, len(values)):
        lo, hi = problem.lo[i], problem.hi[i]
        allowed[n_a + i, 0] = values[i] >= hi - ACTIVE * (sizes[i] + abs(hi))
        allowed[n_a + i, 1] = values[i] <= lo + ACTIVE * (sizes[i] + abs(lo))
    for i in range(k):
        both[i] = beta[i] <= ACTIVE and w[i] <= ACTIVE
        pushes = beta[i] > ACTIVE or (both[i] and sides[i] == PUSHES)
        opens = not pushes and (not both[i] or sides[i] == OPEN)
        allowed[n_a + i, 0], allowed[n_a + i, 1] = opens, not beta[i] > ACTIVE
        allowed[n_a + k + i, 0], allowed[n_a + k + i, 1] = pushes, both[i] or pushes
    return allowed, both


@kernel
def gradient(problem: Scaled, z: Array) -> tuple[Array, Array]:
    """Qz + c and the magnitude of its terms, at least FLOOR of the largest: (n,), (n,)."""
    total, sizes = problem.c.copy(), np.abs(problem.c)
    for i in range(len(z)):
        if z[i] != 0.0:
            for j in range(len(z)):
                term = problem.Q[i, j] * z[i]
                total[j] += term
                sizes[j] += abs(term)
    return total, np.maximum(sizes, FLOOR * largest_magnitude(sizes))


@kernel
def add_multipliers(problem: Scaled, alpha: Array, dual: Array, total: Array) -> None:
    """Add (alpha, 0) + R'dual to a gradient (n,), in place.

    Args:
        problem: scaled.
        alpha: (n_a,) multipliers of the bounds.
        dual: (2k + p,) multipliers of the rows.
        total: (n,) gradient, overwritten.
    """
    n_a = len(alpha)
    k = len(total) - n_a
    for j in range(n_a):
        total[j] += alpha[j]
    for i in range(k):  # the rows of β
        total[n_a + i] += dual[i]
    for i in range(k, len(dual)):
        if dual[i] != 0.0:
            for j in range(len(total)):
                total[j] += problem.R[i, j] * dual[i]


@kernel
def residuals(problem: Scaled, z: Array, alpha: Array, dual: Array) -> Residuals:
    """Objective and residuals of a point (n,), its multipliers of bounds (n_a,) and rows (2k + p,).

    Args:
        problem: scaled.
        z: (n,) the point, scaled.
        alpha: (n_a,) multipliers of the bounds.
        dual: (2k + p,) multipliers of the rows.
    """
    n_a = len(problem.lb)
    k = len(z) - n_a
    values, sizes = row_values(problem, z)
    beta, w = pair_values(problem, z, values, sizes)
    primal = limit_residual(problem, z, values, sizes)
    crossed = 0.0
    for i in range(k):
        primal = max(primal, -beta[i], -w[i])
        crossed = max(crossed, min(beta[i], w[i]))
    # both signs of both sides of a pair: the gains show which of them the piece does not permit
    allowed, both = signs_allowed(problem, z, values, sizes, beta, w, np.zeros(k, dtype=np.int64))
    alpha, dual = permitted_multipliers(alpha, dual, allowed, both)
    total, terms = gradient(problem, z)
    value, magnitude = 0.0, 0.0
    for j in range(len(z)):
        value += 0.5 * z[j] * (total[j] + problem.c[j])
        magnitude += abs(z[j]) * (0.5 * abs(total[j] - problem.c[j]) + abs(problem.c[j]))
    add_multipliers(problem, alpha, dual, total)
    stationarity, gain = 0.0, np.zeros(k)
    for j in range(len(z)):
        if total[j] != 0.0:
            stationarity = max(stationarity, abs(total[j]) / terms[j])
        i = j - n_a
        if i >= 0 and both[i]:
            release = max(dual[i], dual[k + i] * pair_weight(problem, i), 0.0)
            gain[i] = release / terms[j] if release > 0.0 else 0.0
    if not magnitude < np.inf:  # max() above passes over a NaN, this does not
        primal = np.inf
    if not np.sum(np.abs(total)) < np.inf:
        stationarity = np.inf
    return Residuals(value, magnitude, primal, crossed, stationarity, gain, largest_magnitude(gain))


@kernel
def permitted_multipliers(
    alpha: Array, dual: Array, allowed: Bools, both: Bools
) -> tuple[Array, Array]:
    """The multipliers (n_a,), (2k + p,), 0 where a sign is not allowed; of pairs at zero any sign counts.

    Args:
        alpha: (n_a,) multipliers of the bounds.
        dual: (2k + p,) multipliers of the rows.
        allowed: (n_a + 2k + p, 2) of `signs_allowed`.
        both: (k,) pairs with both sides zero.
    """
    n_a, k = len(alpha), len(both)
    alpha, dual = alpha.copy(), dual.copy()
    for j in range(n_a):
        alpha[j] = permitted(alpha[j], allowed[j])
    for i in range(len(dual)):
        if i >= 2 * k or not both[i % k]:
            dual[i] = permitted(dual[i], allowed[n_a + i])
    return alpha, dual


@kernel
def permitted(multiplier: float, allowed: Bools) -> float:
    """A multiplier, 0 where its sign is not allowed."""
    if (multiplier > 0.0 and allowed[0]) or (multiplier < 0.0 and allowed[1]):
        return multiplier
    return 0.0


@kernel
def best_multipliers(problem: Scaled, z: Array, sides: Ints) -> tuple[Array, Array, Array, Bools]:
    """The multipliers of right signs that come closest to cancelling the gradient at z.

    Where active constraints depend on each other the multipliers of a QP are only one choice, so that their
    signs prove nothing; this nonnegative least squares problem covers all choices (Scheel and Scholtes 2000).

    Args:
        problem: scaled.
        z: (n,) the point.
        sides: (k,) as for `signs_allowed`.

    Returns:
        Those of the bounds (n_a,) and of the rows (2k + p,); minus the gradient that is left (n,), zero at a
        stationary point and a direction of descent elsewhere; pairs with both sides zero (k,).
    """
    n, n_a = len(z), len(problem.lb)
    k = n - n_a
    values, sizes = row_values(problem, z)
    beta, w = pair_values(problem, z, values, sizes)
    allowed, both = signs_allowed(problem, z, values, sizes, beta, w, sides)
    # the multiplier of β_i = 0 may have any sign where mode i is open: it cancels its entry of the gradient
    open_ = np.zeros(n, dtype=np.bool_)
    for i in range(k):
        open_[n_a + i] = allowed[n_a + i, 0]
        allowed[n_a + i] = allowed[n_a + i] & (not open_[n_a + i])
    live = np.flatnonzero(~open_)
    most = int(np.sum(allowed))
    rows, source, sign = np.zeros((most, len(live))), np.empty(most, np.int64), np.empty(most)
    count = 0
    for i in range(len(allowed)):
        for side in range(2):
            if not allowed[i, side]:
                continue
            for j in range(len(live)):
                unit_row = 1.0 if live[j] == i else 0.0
                rows[count, j] = unit_row if i < n_a else problem.R[i - n_a, live[j]]
            norm = np.sqrt(np.sum(rows[count] ** 2))
            if norm > 0.0:
                sign[count], source[count] = (1.0 - 2.0 * side) / norm, i
                rows[count] *= sign[count]
                count += 1
    rows = rows[:count]
    slope, _ = gradient(problem, z)
    found, _ = active_set_forces(
        rows @ rows.T, rows @ slope[live], np.zeros(count), RIDGE, 100 + 10 * count
    )
    multipliers = np.zeros(len(allowed))
    for s in range(count):
        multipliers[source[s]] += found[s] * sign[s]
    alpha, dual = multipliers[:n_a].copy(), multipliers[n_a:].copy()
    add_multipliers(problem, alpha, dual, slope)
    for i in range(k):
        if open_[n_a + i]:
            dual[i], slope[n_a + i] = -slope[n_a + i], 0.0
    return alpha, dual, -slope, both


def certify(problem: Qpcc, lam_a: Array, beta: Array) -> Certificate:
    """Residuals of a point, whichever program found it, with the best multipliers there are.

    All three residuals at 1e-8 or less prove that the point is strongly stationary.

    Args:
        problem: the QPCC.
        lam_a: (n_a,) tensions.
        beta: (k,) contact forces.
    """
    numbers, scaled, units = scale(problem)
    if numbers != USABLE:
        return Certificate(np.inf, np.inf, np.inf, np.inf)
    z = np.concatenate([lam_a, beta]) / units.column
    alpha, dual, _, _ = best_multipliers(scaled, z, np.full(len(beta), EITHER))
    found = residuals(scaled, z, alpha, dual)
    return Certificate(found.primal, found.complementarity, found.stationarity, np.inf)
