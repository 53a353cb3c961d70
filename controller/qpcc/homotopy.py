"""A second start: a homotopy from the problem without complementarity to the problem with it.

    min f(z) + ρ β'w(z)   subject to   (2),  w >= 0,  β >= 0                                  (6)

β'w is zero on every piece and positive elsewhere, so that its weight ρ moves the relaxation's optimum into
a piece. As in LCQPow (Hall, Nurkanović, Messerer, Diehl, IEEE Control Systems Letters 6, 2022) the penalty
is linearised, so that from one QP to the next only the linear term changes and the workspace is kept.
"""

from __future__ import annotations

import numpy as np

from tauten.controller.qpcc.descent import Descent
from tauten.controller.qpcc.qp import UNBOUNDED, KeptQp, Qp
from tauten.controller.qpcc.residuals import EXACT
from tauten.controller.qpcc.scaling import Scaled
from tauten.model.numerics import Array

FIRST, FACTOR, LAST = 0.03, 2.0, 1e6  # weights ρ, on a problem whose curvatures are of order one
STEPS = 3  # QPs per weight: exact optima on the way are not needed
PROXIMAL = 1e-7  # curvature that makes the QP's optimum unique, and vanishes as the iteration stops


def penalty_homotopy(descent: Descent) -> None:
    """Follow (6) and descend from every piece on the way."""
    (_, problem), budget = of_order_one(descent.problem), descent.budget
    n, n_a, k = len(problem.c), len(problem.lb), len(problem.c) - len(problem.lb)
    M, m = problem.R[k : 2 * k], problem.r[k : 2 * k]
    penalty = np.zeros((n, n))  # β'w = ½ z' penalty z + slope'z
    penalty[n_a:] += M
    penalty[:, n_a:] += M.T
    slope = np.concatenate([np.zeros(n_a), m])
    qp = relaxation(problem, problem.Q + PROXIMAL * np.eye(n), problem.c)
    kept = KeptQp(qp)
    if not kept.usable or not budget.spend():
        return
    found, z = kept.solve(problem.c)
    rho, piece = FIRST, np.zeros(0, dtype=np.bool_)
    while found and rho < LAST:
        for _ in range(STEPS):
            gradient = problem.c + rho * (penalty @ z + slope)
            if not budget.spend():
                return
            found, y = kept.solve(gradient - PROXIMAL * z)
            if not found:
                return
            suggested = y[n_a:] > M @ y + m
            if not np.array_equal(suggested, piece):
                piece = suggested
                descent.run(piece)
            p = y - z
            fall, curvature = -(problem.Q @ z + gradient) @ p, p @ (problem.Q + rho * penalty) @ p
            z = z + (fall / curvature if curvature > fall > 0.0 else 1.0) * p
            if np.abs(p).max() <= EXACT * np.abs(z).max():
                break
        if np.minimum(z[n_a:], M @ z + m).max(initial=0.0) <= EXACT * np.abs(z).max():
            return
        rho *= FACTOR


def of_order_one(problem: Scaled) -> tuple[float, Scaled]:
    """τ and the problem in z / τ, so that gaps and limits are of order one, as QP tolerances expect."""
    rows = np.concatenate([problem.r, problem.lo, problem.hi])
    for values in (rows, problem.lb, problem.ub):
        finite = np.abs(values[np.abs(values) < UNBOUNDED])
        tau = float(finite.max(initial=0.0))
        if tau > 0.0:
            break
    else:
        tau = 1.0
    lb, ub, lo, hi = (
        np.where(np.abs(end) < UNBOUNDED, end / tau, end)
        for end in (problem.lb, problem.ub, problem.lo, problem.hi)
    )
    return tau, Scaled(problem.Q, problem.c / tau, lb, ub, problem.R, problem.r / tau, lo, hi)


def relaxation(problem: Scaled, H: Array, f: Array) -> Qp:
    """The QP with an objective (n, n), (n,) over the problem without complementarity.

    Args:
        problem: scaled.
        H: (n, n) Hessian of the objective, scaled.
        f: (n,) gradient of the objective at zero, scaled.
    """
    k = len(problem.c) - len(problem.lb)
    zero, free = np.zeros(k), np.full(k, UNBOUNDED)
    r, limits = problem.r[k : 2 * k], slice(2 * k, None)
    lower = np.concatenate([problem.lb, zero, -r, problem.lo[limits]])
    upper = np.concatenate([problem.ub, free, free, problem.hi[limits]])
    return Qp(H, f, np.ascontiguousarray(problem.R[k:]), lower, upper)
