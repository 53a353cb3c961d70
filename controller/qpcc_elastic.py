"""Least violation of the limits: the QPCC with its limits made elastic.

    min 1/2 |s|² + σ f(a, β)   s.t.   g_lo <= G z + s <= g_hi, bounds and complementarity as before

It has a feasible point wherever the complementarity has one, and is a QPCC in ((a, s), β) again, so that
the same descent solves it.
"""

from __future__ import annotations

import numpy as np
from tauten.controller.qp import UNBOUNDED, Backend
from tauten.controller.qpcc_descent import Descent, Point
from tauten.controller.qpcc_scaling import Scaled
from tauten.model.arrays import Bools

SIGMA = 1e-8


def least_violation(
    problem: Scaled, backend: Backend, max_pivots: int, piece: Bools
) -> Point | None:
    """The point that violates the limits least, seen from a piece; s is taken out again."""
    n_a, k, p = len(problem.lb), problem.k, len(problem.r) - 2 * problem.k
    descent = Descent(elastic(problem), backend, max_pivots)
    descent.run(piece)
    best = descent.best
    if best is None:
        return None
    keep = np.r_[0:n_a, n_a + p : n_a + p + k]
    violation = best.z[n_a : n_a + p]
    return Point(
        z=best.z[keep],
        piece=best.piece,
        objective=problem.objective(best.z[keep]),
        primal=float(np.abs(violation).max(initial=0.0)),
        complementarity=best.complementarity,
        stationarity=best.stationarity,
        wrong=best.wrong,
        alpha=best.alpha[:n_a],
        dual=best.dual,
    )


def elastic(problem: Scaled) -> Scaled:
    """The problem with a slack for every limit among its a."""
    n_a, k, p = len(problem.lb), problem.k, len(problem.r) - 2 * problem.k
    n = n_a + p + k
    keep = np.r_[0:n_a, n_a + p : n]
    Q, c = np.zeros((n, n)), np.zeros(n)
    Q[np.ix_(keep, keep)] = SIGMA * problem.Q
    Q[range(n_a, n_a + p), range(n_a, n_a + p)] = 1.0
    c[keep] = SIGMA * problem.c
    R = np.zeros((len(problem.r), n))
    R[:, keep] = problem.R
    R[range(2 * k, 2 * k + p), range(n_a, n_a + p)] = 1.0
    free = np.full(p, UNBOUNDED)
    return Scaled(
        Q=Q, c=c, R=R, r=problem.r, lo=problem.lo, hi=problem.hi,
        lb=np.concatenate([problem.lb, -free]), ub=np.concatenate([problem.ub, free]),
        column=np.ones(n), cost=1.0,
    )  # fmt: skip
