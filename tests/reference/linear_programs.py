"""What HiGHS says of a QPCC: whether it has a feasible point, whether a direction leads down from one.

Linear programs over all choices of sides, by `scipy.optimize.linprog`: slow, and without code of the solver
but the units that `scale` chooses.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from scipy.optimize import linprog

from tauten.controller.qpcc import UNBOUNDED, Qpcc, Scaled, scale
from tauten.model.numerics import Array, Bools

ACTIVE = 1e-7  # relative to the terms of a row


def has_feasible_point(problem: Qpcc) -> bool:
    """Whether any of the 2ᵏ pieces has a point."""
    _, scaled, _ = scale(problem)
    n_a, k = len(problem.lb), len(problem.m)
    M, G = scaled.R[k : 2 * k], scaled.R[2 * k :]
    ends = [scaled.lb, scaled.ub, scaled.lo[2 * k :], scaled.hi[2 * k :], scaled.r[k : 2 * k]]
    # the tolerances of HiGHS are absolute: gaps and limits of rows become of order one
    known = [np.abs(end[np.abs(end) < UNBOUNDED]).max(initial=0.0) for end in ends]
    unit = max(known[2:]) or max(known[:2]) or 1.0
    lb, ub, lo, hi, m = (np.where(np.abs(end) < UNBOUNDED, end / unit, end) for end in ends)
    lower, upper = np.r_[lb, np.zeros(k)], np.r_[ub, np.full(k, UNBOUNDED)]
    for sides in product((False, True), repeat=k):
        pushes = np.array(sides, dtype=np.bool_)
        top = np.where(np.r_[np.ones(n_a, np.bool_), pushes], upper, 0.0)
        rows = np.vstack([M[~pushes], G])
        floor, ceiling = np.r_[-m[~pushes], lo], np.r_[np.full(np.sum(~pushes), UNBOUNDED), hi]
        if possible(rows, floor, ceiling, M[pushes], -m[pushes], lower, top):
            return True
    return False


def possible(
    rows: Array,
    floor: Array,
    ceiling: Array,
    equal: Array,
    value: Array,
    lower: Array,
    upper: Array,
) -> bool:
    """Whether floor <= rows z <= ceiling, equal z = value, lower <= z <= upper has a solution."""
    if len(lower) == 0:
        return bool(np.all(floor <= 0.0) and np.all(ceiling >= 0.0) and np.all(value == 0.0))
    ends = np.where(lower > -UNBOUNDED, lower, -np.inf), np.where(upper < UNBOUNDED, upper, np.inf)
    up, down = ceiling < UNBOUNDED, floor > -UNBOUNDED
    found = linprog(
        np.zeros(len(lower)),
        A_ub=np.vstack([rows[up], -rows[down]]),
        b_ub=np.r_[ceiling[up], -floor[down]],
        A_eq=equal,
        b_eq=value,
        bounds=np.c_[ends],
        method="highs",
    )
    return bool(found.status == 0)


def steepest_slope(problem: Qpcc, lam_a: Array, beta: Array) -> float:
    """The least slope of the objective along directions into any piece; zero at a B-stationary point.

    Directions are of at most one in every scaled variable; slopes relative to the gradient's terms.
    """
    _, p, units = scale(problem)
    z = np.concatenate([lam_a, beta]) / units.column
    n_a, k = len(lam_a), len(beta)
    if len(z) == 0:
        return 0.0
    g = p.Q @ z + p.c
    size = float((np.abs(p.Q) @ np.abs(z) + np.abs(p.c)).max())
    if size == 0.0:
        return 0.0
    values, sizes = p.R @ z + p.r, np.abs(p.R) @ np.abs(z) + np.abs(p.r)
    sizes = np.maximum(sizes, 1e-3 * np.abs(p.R).max(axis=1) * np.abs(z).max())
    tiny = ACTIVE * sizes
    pair = np.maximum(tiny[:k], tiny[k : 2 * k])
    push, gap = values[:k] > pair, values[k : 2 * k] > pair
    close = 1e-12 * np.abs(z).max()
    low = np.where(np.r_[z[:n_a] <= p.lb + close, ~push], 0.0, -1.0)
    high = np.where(np.r_[z[:n_a] >= p.ub - close, np.zeros(k, np.bool_)], 0.0, 1.0)
    worst = 0.0
    both = np.flatnonzero(~push & ~gap)
    for sides in product((False, True), repeat=min(len(both), 7)):
        pushes = push.copy()
        pushes[both[: len(sides)]] = sides
        slope = least_slope(p, g / size, low, high, pushes, values, tiny, gap)
        worst = min(worst, slope)
    return worst


def least_slope(
    p: Scaled,
    g: Array,
    low: Array,
    high: Array,
    pushes: Bools,
    values: Array,
    tiny: Array,
    gap: Bools,
) -> float:
    """The least g'd over the directions d (n,) that remain in one piece."""
    k, n_a = len(pushes), len(p.lb)
    M, G = p.R[k : 2 * k], p.R[2 * k :]
    lo, hi = p.lo[2 * k :], p.hi[2 * k :]
    at_lo = values[2 * k :] <= lo + np.maximum(tiny[2 * k :], ACTIVE * np.abs(lo))
    at_hi = values[2 * k :] >= hi - np.maximum(tiny[2 * k :], ACTIVE * np.abs(hi))
    top = high.copy()
    top[n_a:][~pushes] = 0.0
    closed = ~pushes & ~gap
    rows = np.vstack([-M[closed], -G[at_lo], G[at_hi]])
    found = linprog(
        g, A_ub=rows, b_ub=np.zeros(len(rows)), A_eq=M[pushes], b_eq=np.zeros(int(pushes.sum())),
        bounds=np.c_[np.minimum(low, top), top], method="highs",
    )  # fmt: skip
    return float(found.fun) if found.status == 0 else 0.0
