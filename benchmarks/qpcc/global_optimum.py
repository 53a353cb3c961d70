"""The global optimum of a QPCC, or a bound on it: best-first branch and bound over the modes.

A node fixes some modes to push or to be open and relaxes the others to β >= 0, w >= 0: a convex QP
whose value bounds all pieces below. Adding ρ β'w >= 0, which is zero in every piece, to the objective
lifts the bounds; ρ is as large as convexity allows. Every node's point suggests a piece, from which the
solver's descent runs. Each relaxation is solved from the beginning: a kept workspace of daqp may call
feasible ones infeasible, which would prove what is not so (ex9.1.7 of MacMPEC).
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from tauten.controller.qpcc import (
    UNBOUNDED,
    USABLE,
    Budget,
    Descent,
    Qp,
    Qpcc,
    Scaled,
    Start,
    TimeLimit,
    relaxation,
    scale,
    solve_daqp,
    solve_qpcc,
)
from tauten.model.numerics import Array, Ints, kernel

GAP = 1e-7  # relative; nodes whose bound allows less improvement are discarded
FLAT = 1e-9  # slope of the Lagrangian, relative to its terms, that round-off may leave


@dataclass(frozen=True, slots=True)
class GlobalOptimum:
    """Result of a search.

    Attributes:
        objective: of the best point found, +inf without any.
        bound: no feasible point has a lower objective; +inf: there is no feasible point.
    """

    objective: float
    bound: float

    @property
    def proved(self) -> bool:
        """Whether the objective is the optimum, or no feasible point exists, within 1e-6."""
        if not np.isfinite([self.objective, self.bound]).all():
            return self.bound == np.inf
        return self.objective - self.bound <= 1e-6 * max(abs(self.objective), abs(self.bound))


def branch_and_bound(problem: Qpcc, start: Start | None, seconds: float) -> GlobalOptimum:
    """Search until the optimum is proved or the time is over.

    Args:
        problem: the QPCC.
        start: of a first descent.
        seconds: wall time.
    """
    end = perf_counter() + seconds
    numbers, scaled, units = scale(problem)
    if numbers != USABLE:
        return GlobalOptimum(np.inf, -np.inf)
    first = solve_qpcc(problem, start)
    descent = Descent(scaled, solve_daqp, Budget(1_000_000, TimeLimit(seconds)))
    if first.status.usable:
        descent.run(first.piece)
    bound = explore(descent, problem.constant / units.cost, end)
    best = first.objective if first.status.usable else np.inf
    if descent.best is not None:
        best = min(best, descent.best.residuals.objective * units.cost + problem.constant)
    return GlobalOptimum(best, min(bound * units.cost + problem.constant, best))


def explore(descent: Descent, offset: float, end: float) -> float:
    """Lowest bound of all nodes that are left; that of the best point where none is, +inf without one.

    Args:
        descent: collects the best point, with the scaled problem.
        offset: constant of the objective, scaled.
        end: value of `perf_counter` at which to stop [s].
    """
    problem = descent.problem
    n_a, k = len(problem.lb), len(problem.c) - len(problem.lb)
    M, m = problem.R[k : 2 * k], problem.r[k : 2 * k]
    qp = relaxation(problem, *lifted_objective(problem, k))
    heap: list[tuple[float, int, Ints]] = [(-np.inf, 0, np.zeros(k, dtype=np.int64))]
    number, lost = 0, np.inf  # lost: lowest value of a node whose piece was not solved to its value
    while heap:
        if perf_counter() > end:
            return min(heap[0][0], lost)
        bound, _, sides = heapq.heappop(heap)
        if bound >= enough(descent, offset):
            return min(bound, lost)
        upper = qp.upper.copy()
        upper[n_a : n_a + k][sides < 0] = 0.0
        upper[n_a + k : n_a + 2 * k][sides > 0] = -m[sides > 0]
        answer = solve_daqp(Qp(qp.H, qp.f, qp.A, qp.lower, upper))
        if answer.infeasible:
            continue
        value = dual_value(qp.H, qp.f, qp.A, qp.lower, upper, answer.y, answer.multipliers)
        bound = max(bound, value) if value > -np.inf else bound  # NaN is no bound
        if bound >= enough(descent, offset):
            lost = min(lost, bound)
            continue
        beta, w = answer.y[n_a:], M @ answer.y + m
        descent.run(np.where(sides == 0, beta > w, sides > 0))
        crossed = np.where(sides == 0, np.minimum(beta, w), -1.0)
        pair = int(np.argmax(crossed)) if k else 0
        if k == 0 or crossed[pair] < 0.0 or bound >= enough(descent, offset):
            lost = min(lost, bound)
            continue
        for side in (1, -1):
            number += 1
            heapq.heappush(heap, (bound, number, np.where(np.arange(k) == pair, side, sides)))
    return lost


def enough(descent: Descent, offset: float) -> float:
    """The bound from which on the best point counts as the global optimum."""
    if descent.best is None:
        return np.inf
    value, terms = descent.best.residuals.objective, descent.best.residuals.terms
    slope = min(float(np.abs(descent.problem.c).max(initial=0.0)), 1e100)
    # curvatures are one or less: slope² is what objectives are differences of, also around z = 0
    return float(value - GAP * abs(value + offset) - 1e-11 * (terms + slope**2))


@kernel
def dual_value(
    H: Array, f: Array, A: Array, lower: Array, upper: Array, y: Array, multipliers: Array
) -> float:
    """A number below the objective of all feasible points of a QP, however good the answer y is.

    The minimum over the box lower <= x <= upper of the Lagrangian, linearised at y:
    L(x) = 1/2 x'Hx + f'x + μ'(Ax - limits) is convex and below the objective wherever Ax is within its
    limits, so that L(y) + min g'(x - y), g = Hy + f + A'μ, is a bound.

    Args:
        H: (n, n).
        f: (n,).
        A: (m, n).
        lower: (n + m,).
        upper: (n + m,).
        y: (n,) a point, feasible or not; the better the tighter the bound.
        multipliers: (n + m,) with the signs of `QpAnswer`.
    """
    n = len(f)
    g, size = f.copy(), np.abs(f)
    value = 0.0
    for i in range(n):
        slope = 0.0
        for j in range(n):
            slope += H[i, j] * y[j]
            size[i] += abs(H[i, j] * y[j])
        g[i] += slope
        value -= 0.5 * slope * y[i]  # with g'x below: 1/2 y'Hy + f'y + ... - g'y
    for i in range(len(A)):
        mu = multipliers[n + i]
        limit = upper[n + i] if mu > 0.0 else lower[n + i]
        if mu != 0.0 and abs(limit) < UNBOUNDED:
            value -= mu * limit
            for j in range(n):
                g[j] += mu * A[i, j]
                size[j] += abs(mu * A[i, j])
    for j in range(n):
        nearest = lower[j] if g[j] > 0.0 else upper[j]
        if abs(nearest) < UNBOUNDED:
            value += g[j] * nearest
        elif abs(g[j]) > FLAT * size[j]:
            return -np.inf
    return value


def lifted_objective(problem: Scaled, k: int) -> tuple[Array, Array]:
    """Hessian and gradient of the objective + ρ β'(Mz + m), with the largest ρ = 2⁻ⁱ that is convex."""
    n = len(problem.c)
    product, linear = np.zeros((n, n)), np.zeros(n)
    product[n - k :] = problem.R[k : 2 * k]
    product += product.T
    linear[n - k :] = problem.r[k : 2 * k]
    for rho in 2.0 ** -np.arange(0.0, 24.0):
        if convex(problem.Q + rho * product):
            return problem.Q + rho * product, problem.c + rho * linear
    return problem.Q, problem.c


def convex(H: Array) -> bool:
    """Whether a matrix is positive semidefinite up to round-off."""
    try:
        np.linalg.cholesky(H + 1e-13 * np.max(np.diag(H), initial=0.0) * np.eye(len(H)))
    except np.linalg.LinAlgError:
        return False
    return True
