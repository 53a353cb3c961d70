"""A piece of a QPCC with one tension: its QP is a parabola over an interval, solved where it is made.

For a robot of one cable this is nearly every piece. One compiled pass from the problem to the point takes a
third of the time of handing eight arrays to a QP library and back.
"""

from __future__ import annotations

import numpy as np

from tauten.controller.qp import UNBOUNDED
from tauten.controller.qpcc_pieces import reduce_piece
from tauten.controller.qpcc_recovery import recover
from tauten.controller.qpcc_scaling import Scaled
from tauten.controller.residuals import Judgement
from tauten.model.arrays import Array, Bools
from tauten.model.jit import kernel


@kernel
def solve_one_cable(problem: Scaled, pushes: Bools) -> tuple[bool, Array, Array, Array, Judgement]:
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
