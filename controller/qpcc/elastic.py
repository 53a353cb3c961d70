"""Least violation of the limits: the QPCC with its limits made elastic.

    min 1/2 |s|² + σ f(a, β)   s.t.   g_lo <= G z + s <= g_hi,  bounds and complementarity as before

It has a feasible point wherever the complementarity has one, and is a QPCC in ((a, s), β) again, so
that the same descent solves it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tauten.controller.qpcc.descent import Descent, Point
from tauten.controller.qpcc.qp import UNBOUNDED, Backend
from tauten.controller.qpcc.residuals import judge
from tauten.controller.qpcc.scaling import Scaled
from tauten.model.numerics import Bools, Ints

SIGMA = 1e-8  # chooses among points that violate the limits equally


def least_violation(
    problem: Scaled, backend: Backend, max_pivots: int, piece: Bools
) -> Point | None:
    """The point that violates the limits least, seen from a piece.

    `dual[2k:]` of the point is minus its violations.
    """
    n_a, p = len(problem.lb), len(problem.r) - 2 * len(piece)
    descent = Descent(elastic(problem, len(piece)), backend, max_pivots)
    descent.run(piece)
    best = descent.best
    if best is None:
        return None
    z, alpha = best.z[own_variables(n_a, p, len(piece))], best.alpha[:n_a]
    worth = judge(problem, z, alpha, np.zeros(len(problem.r)))
    return replace(best, z=z, alpha=alpha, worth=worth)


def own_variables(n_a: int, p: int, k: int) -> Ints:
    """Where a and β stand among (a, s, β)."""
    return np.concatenate([np.arange(n_a), np.arange(n_a + p, n_a + p + k)])


def elastic(problem: Scaled, k: int) -> Scaled:
    """The problem with a slack for every limit among its a."""
    n_a, p = len(problem.lb), len(problem.r) - 2 * k
    n, keep = n_a + p + k, own_variables(n_a, p, k)
    slack = np.arange(n_a, n_a + p)
    Q, c, R = np.zeros((n, n)), np.zeros(n), np.zeros((len(problem.r), n))
    Q[np.ix_(keep, keep)] = SIGMA * problem.Q
    Q[slack, slack] = 1.0
    c[keep] = SIGMA * problem.c
    R[:, keep] = problem.R
    R[2 * k + np.arange(p), slack] = 1.0
    free = np.full(p, UNBOUNDED)
    lb, ub = np.concatenate([problem.lb, -free]), np.concatenate([problem.ub, free])
    return Scaled(Q, c, lb, ub, R, problem.r, problem.lo, problem.hi)
