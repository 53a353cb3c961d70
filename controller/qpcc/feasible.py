"""A feasible point where the descent found none, or the point that violates the limits least.

    min 1/2 |s|² + σ f(a, β)   s.t.   g_lo <= G z + s <= g_hi,  bounds and complementarity as before   (7)

has a feasible point wherever the complementarity has one, and is a QPCC in ((a, s), β) again, so that the
same descent solves it. Where that ends at a violation, which may be a local minimum, a tree search over the
modes looks for a feasible piece elsewhere.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tauten.controller.qpcc.descent import Descent, DescentPoint
from tauten.controller.qpcc.homotopy import of_order_one, relaxation
from tauten.controller.qpcc.qp import ENDLESS, UNBOUNDED, Qp, solve_daqp, solve_redundant
from tauten.controller.qpcc.residuals import OPEN, PUSHES, residuals
from tauten.controller.qpcc.scaling import Scaled
from tauten.model.numerics import Bools, Ints

SIGMA = 1e-8  # chooses among points that violate the limits equally


def least_violation(descent: Descent, piece: Bools) -> DescentPoint | None:
    """The point that violates the limits least, found by a descent from a piece.

    Where its violation is zero the descent of the problem itself continues from there.

    `dual[2k:]` of the point is minus its violations.
    """
    problem, k = descent.problem, len(piece)
    n_a, p = len(problem.lb), len(problem.r) - 2 * k
    search = Descent(elastic(problem, k), solve_daqp, descent.budget)
    search.run(piece)
    best = search.best
    if best is None:
        return None
    z, alpha = best.z[own_variables(n_a, p, k)], best.alpha[:n_a]
    descent.run(best.piece)
    if descent.best is None:
        descent.keep_point(z, best.piece)
    found = residuals(problem, z, alpha, np.zeros(len(problem.r)))
    return replace(best, z=z, alpha=alpha, residuals=found)


def own_variables(n_a: int, p: int, k: int) -> Ints:
    """Where a and β are among (a, s, β)."""
    return np.concatenate([np.arange(n_a), np.arange(n_a + p, n_a + p + k)])


def elastic(problem: Scaled, k: int) -> Scaled:
    """Problem (7), a slack for every limit among its a."""
    n_a, p = len(problem.lb), len(problem.r) - 2 * k
    n, own = n_a + p + k, own_variables(n_a, p, k)
    slack = np.arange(n_a, n_a + p)
    Q, c, R = np.zeros((n, n)), np.zeros(n), np.zeros((len(problem.r), n))
    Q[np.ix_(own, own)] = SIGMA * problem.Q
    Q[slack, slack] = 1.0
    c[own] = SIGMA * problem.c
    R[:, own] = problem.R
    R[2 * k + np.arange(p), slack] = 1.0
    free = np.full(p, UNBOUNDED)
    lb, ub = np.concatenate([problem.lb, -free]), np.concatenate([problem.ub, free])
    return Scaled(Q, c, lb, ub, R, problem.r, problem.lo, problem.hi)


def all_empty(descent: Descent) -> bool:
    """Search all pieces for a feasible point, depth first; True when it is proved that none exists.

    A node fixes some modes and relaxes the others to β >= 0, w >= 0. Every relaxation is solved from the
    beginning, because a kept workspace may take feasible ones for empty (ex9.1.7 of MacMPEC). Ends at the
    first point, or when the budget is spent.
    """
    tau, problem = of_order_one(descent.problem)
    n_a, k = len(problem.lb), len(problem.c) - len(problem.lb)
    M, m = problem.R[k : 2 * k], problem.r[k : 2 * k]
    qp = relaxation(problem, np.eye(len(problem.c)), np.zeros(len(problem.c)))
    stack: list[Ints] = [np.zeros(k, dtype=np.int64)]
    shown = True
    while stack:
        if not descent.budget.spend():
            return False
        sides = stack.pop()
        upper = qp.upper.copy()
        upper[n_a : n_a + k][sides == OPEN] = 0.0
        upper[n_a + k : n_a + 2 * k][sides == PUSHES] = -m[sides == PUSHES]
        node = Qp(qp.H, qp.f, qp.A, qp.lower, upper)
        answer = solve_daqp(node)
        if answer.infeasible:
            answer = solve_redundant(node)
        if answer.infeasible:
            continue
        if not np.abs(answer.y).max(initial=0.0) < ENDLESS:  # no answer
            shown = False
            continue
        beta, w = answer.y[n_a:], M @ answer.y + m
        piece = np.where(sides == 0, beta > w, sides == PUSHES)
        descent.run(piece)
        if descent.best is None:  # where the piece is too badly conditioned to be eliminated
            descent.keep_point(tau * answer.y, piece)
        if descent.best is not None:
            return False
        free = np.flatnonzero(sides == 0)
        if len(free) == 0:  # not empty, and not solved either
            shown = False
            continue
        pair = free[np.argmax(np.minimum(beta, w)[free])]
        first = PUSHES if beta[pair] > w[pair] else OPEN
        for side in (-first, first):  # the last one is taken first
            stack.append(np.where(np.arange(k) == pair, side, sides))
    return shown
