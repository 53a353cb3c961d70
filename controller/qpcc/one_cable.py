"""A QPCC with one tension: a piece's QP is a parabola over an interval, solved where it is made.

For a robot of one cable this is nearly every piece. One compiled pass from the problem to the point takes a
third of the time of handing eight arrays to a QP library and back. And with one limit, as on its pulled
length, a point within it is found along the tension, without an elastic problem.
"""

from __future__ import annotations

import numpy as np

from tauten.controller.qpcc.lcp_start import feasible_start
from tauten.controller.qpcc.pieces import eliminate_pushing, reduce_piece
from tauten.controller.qpcc.qp import UNBOUNDED
from tauten.controller.qpcc.recovery import recover
from tauten.controller.qpcc.residuals import Residuals
from tauten.controller.qpcc.scaling import Scaled
from tauten.model.numerics import Array, Bools, kernel

TRIES = 10  # pieces on the way to a limit; as a rule one or two
INSIDE = 1e-2  # of the width between two limits, how far within them to aim


@kernel
def solve_one_cable(problem: Scaled, pushes: Bools) -> tuple[bool, Array, Array, Array, Residuals]:
    """Optimum of a piece whose QP has one variable.

    Returns:
        Whether it was found: not when the piece has more variables, is empty or has no minimum; z,
        multipliers and worth as of `recover`.
    """
    possible, H, f, A, lower, upper, reduction = reduce_piece(problem, pushes)
    y, multipliers = np.zeros(len(f)), np.zeros(len(lower))
    found = possible and len(f) == 1
    if found:
        found = parabola(H[0, 0], f[0], A, lower, upper, y, multipliers)
    return found, *recover(problem, pushes, reduction, y, multipliers)


@kernel
def parabola(
    H: float, f: float, A: Array, lower: Array, upper: Array, y: Array, multipliers: Array
) -> bool:
    """Solve `qp.Qp` with one variable; False when nothing satisfies the limits or there is no minimum.

    Args:
        H: at least zero.
        f: slope at zero.
        A: (m, 1).
        lower: (1 + m,).
        upper: (1 + m,).
        y: (1,) the solution, overwritten.
        multipliers: (1 + m,) zeros; that of the limit which holds is overwritten, as in `qp.QpAnswer`.
    """
    low, high, at_low, at_high = lower[0], upper[0], 0, 0
    for i in range(len(A)):
        a = A[i, 0]
        if a == 0.0:  # rows that do not depend on y were left out
            continue
        one, other = lower[1 + i] / a, upper[1 + i] / a
        if min(one, other) > low:
            low, at_low = min(one, other), 1 + i
        if max(one, other) < high:
            high, at_high = max(one, other), 1 + i
    if not low <= high:
        return False
    free = -f / H if H > 0.0 else -np.sign(f) * UNBOUNDED
    y[0] = min(max(free, low), high)
    if not abs(y[0]) < UNBOUNDED:
        return False
    if y[0] != free:
        holds = at_low if free < low else at_high
        multipliers[holds] = -(H * y[0] + f) / (A[holds - 1, 0] if holds > 0 else 1.0)
    return True


@kernel
def within_limit(problem: Scaled, z: Array, pushes: Bools) -> tuple[bool, Bools, Array]:
    """A point that satisfies the one limit of a problem of one tension.

    The limited length grows with the tension in straight pieces, along the contact forces that the tension
    causes: Newton's method.

    Args:
        problem: n_a = 1, p = 1.
        z: (n,) tension and the contact forces there.
        pushes: (k,) their piece.

    Returns:
        Whether there may be one: as near as tensions and rounding come to the limit; its piece, z.
    """
    k = len(pushes)
    M, m, row = problem.R[k : 2 * k], problem.r[k : 2 * k], problem.R[2 * k]
    low, high = problem.lo[2 * k], problem.hi[2 * k]
    margin = INSIDE * (high - low) if high - low < UNBOUNDED else 0.0
    for _ in range(TRIES):
        value = np.dot(row, z)
        if low <= value <= high:
            return True, pushes, z
        goal = low + margin if value < low else high - margin
        pushing = eliminate_pushing(M, m, np.flatnonzero(pushes), 1)
        slope = row[0]
        for s in range(pushing.rank):
            slope += row[1 + pushing.cols[s]] * pushing.beta[s, 0]
        if not slope > 0.0:
            break
        tension = min(max(z[0] + (goal - value) / slope, problem.lb[0]), problem.ub[0])
        if not abs(tension - z[0]) > 0.0:  # at a bound, or within rounding of the limit
            return True, pushes, z
        found, pushes, z = feasible_start(problem, np.array([tension]), pushes)
        if not found:
            break
    return False, pushes, z
