"""Make a QP's solution exact: guess its active set, solve the equations, correct the guess.

Operator splitting and augmented Lagrangians stop at residuals of 1e-6 to 1e-9, and even an active-set
method loses digits where H is singular. The primal-dual active set iteration (Bergounioux, Ito, Kunisch
1999) takes over from there: it ends in one step when the guess is right.
"""

from __future__ import annotations

import numpy as np

from tauten.controller.qpcc.elimination import back_substitute, eliminate
from tauten.controller.qpcc.qp import Qp, QpAnswer
from tauten.model.numerics import Array, Ints, kernel

ROUNDS = 10
VIOLATION = 1e-10  # of limits and signs, on a QP of order one


def polished(qp: Qp, answer: QpAnswer) -> QpAnswer:
    """The exact solution near an answer; the answer itself where that is not found."""
    found, y, multipliers = polish(
        qp.H, qp.f, qp.A, qp.lower, qp.upper, answer.y, answer.multipliers
    )
    return QpAnswer(False, y, multipliers) if found else answer


@kernel
def polish(
    H: Array, f: Array, A: Array, lower: Array, upper: Array, y: Array, multipliers: Array
) -> tuple[bool, Array, Array]:
    """Found, y (n,), multipliers (n + m,)."""
    rows = np.concatenate((np.eye(len(f)), A))
    side = active_sides(rows, lower, upper, y, multipliers, VIOLATION)
    for _ in range(ROUNDS):
        solved, y, multipliers = solve_equations(H, f, rows, lower, upper, side)
        if not solved:
            break
        following = active_sides(rows, lower, upper, y, multipliers, VIOLATION)
        if np.all(following == side):
            return True, y, multipliers
        side = following
    return False, y, multipliers


@kernel
def active_sides(
    rows: Array, lower: Array, upper: Array, y: Array, multipliers: Array, tolerance: float
) -> Ints:
    """1 where the upper limit holds, -1 where the lower one does, 0 elsewhere: (n + m,)."""
    side = np.zeros(len(rows), dtype=np.int64)
    for i in range(len(rows)):
        value = 0.0
        for j in range(len(y)):
            value += rows[i, j] * y[j]
        if multipliers[i] + (value - upper[i]) > tolerance:
            side[i] = 1
        elif multipliers[i] + (value - lower[i]) < -tolerance:
            side[i] = -1
    return side


@kernel
def solve_equations(
    H: Array, f: Array, rows: Array, lower: Array, upper: Array, side: Ints
) -> tuple[bool, Array, Array]:
    """Minimum on the active limits; a basic solution where they depend on each other."""
    active = np.flatnonzero(side)
    n, p = len(f), len(active)
    K, X = np.zeros((n + p, n + p)), np.zeros((n + p, 1))
    K[:n, :n] = H
    X[:n, 0] = -f
    for s in range(p):
        i = active[s]
        K[n + s, :n] = rows[i]
        K[:n, n + s] = rows[i]
        X[n + s, 0] = upper[i] if side[i] > 0 else lower[i]
    rank, _, cols = eliminate(K, X)
    back_substitute(K, X, rank)
    solved = True
    for s in range(rank, n + p):
        solved = solved and abs(X[s, 0]) < VIOLATION
    solution = np.zeros(n + p)
    for s in range(rank):
        solution[cols[s]] = X[s, 0]
    multipliers = np.zeros(len(rows))
    for s in range(p):
        multipliers[active[s]] = solution[n + s]
    return solved, solution[:n], multipliers
