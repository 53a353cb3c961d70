"""From the QP of a piece back to the QPCC: variables, all multipliers, and what they are worth."""

from __future__ import annotations

import numpy as np

from tauten.controller.qpcc.elimination import solve_transposed
from tauten.controller.qpcc.pieces import Pushing, Reduction
from tauten.controller.qpcc.residuals import Residuals, judge
from tauten.controller.qpcc.scaling import Scaled
from tauten.model.numerics import Array, Bools, kernel

ROUND_OFF = 1e-14  # of y, which is of order one


@kernel
def recover(
    problem: Scaled, pushes: Bools, reduction: Reduction, y: Array, multipliers: Array
) -> tuple[Array, Array, Array, Residuals]:
    """Z (n,), multipliers of the bounds (n_a,) and of all rows (2k + p,) from a piece's QP.

    Signs are those of `qp.QpAnswer`: Qz + c + (alpha, 0) + R'dual = 0, positive where an upper limit
    holds.
    """
    n_a, k = len(problem.lb), len(pushes)
    tau, T = reduction.tau, reduction.T
    cols, rank = reduction.pushing.cols, reduction.pushing.rank
    z = reduction.t.copy()
    for j in range(len(y)):
        if abs(y[j]) > ROUND_OFF:  # else the residuals of a solution z = 0 were noise over noise
            for i in range(len(z)):
                z[i] += tau * T[i, j] * y[j]
    alpha, dual = np.zeros(n_a), np.zeros(len(problem.r))
    for j in range(n_a):
        alpha[j] = tau * multipliers[j] / T[j, j]
        z[j] = min(max(z[j], problem.lb[j]), problem.ub[j])
        if alpha[j] != 0.0:
            z[j] = problem.ub[j] if alpha[j] > 0.0 else problem.lb[j]
    for i in range(k):
        z[n_a + i] = max(z[n_a + i], 0.0) if pushes[i] else 0.0
    for j in range(n_a, len(y)):
        i = cols[rank + j - n_a]
        dual[i] = tau * multipliers[j] / T[n_a + i, j]
    for i in range(len(reduction.source)):
        dual[reduction.source[i]] = tau * multipliers[len(y) + i]
    eliminated_multipliers(problem, pushes, reduction.pushing, z, dual)
    return z, alpha, dual, judge(problem, z, alpha, dual)


@kernel
def eliminated_multipliers(
    problem: Scaled, pushes: Bools, pushing: Pushing, z: Array, dual: Array
) -> None:
    """Complete `dual`: equations w_I = 0 from the columns of β_I, then β_J = 0 from their own."""
    n_a, k, rank = len(problem.lb), len(pushes), pushing.rank
    g = gradient(problem, z, dual)  # (n,)
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


@kernel
def gradient(problem: Scaled, z: Array, dual: Array) -> Array:
    """Qz + c + R'dual: (n,)."""
    total = problem.c.copy()
    for i in range(len(z)):
        if z[i] != 0.0:
            for j in range(len(z)):
                total[j] += problem.Q[i, j] * z[i]
    for i in range(len(dual)):
        if dual[i] != 0.0:
            for j in range(len(z)):
                total[j] += problem.R[i, j] * dual[i]
    return total
