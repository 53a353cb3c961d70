"""What the answer to a convex QP proves about its optimal value, however good the answer is."""

from __future__ import annotations

import numpy as np

from tauten.controller.qpcc.qp import UNBOUNDED, Qp
from tauten.model.numerics import Array, kernel

FLAT = 1e-9  # slope of the Lagrangian, relative to its terms, that round-off may leave


def lower_bound(qp: Qp, upper: Array, y: Array, multipliers: Array) -> float:
    """A number below the objective of all feasible points of a QP with other upper limits.

    Args:
        qp: the QP; its `upper` is not used.
        upper: (n + m,) the upper limits.
        y: (n,) a point, feasible or not; the better the tighter the bound.
        multipliers: (n + m,) with the signs of `qp.QpAnswer`.
    """
    value = float(dual_value(qp.H, qp.f, qp.A, qp.lower, upper, y, multipliers))
    return value if value > -np.inf else -np.inf  # NaN is no bound


@kernel
def dual_value(
    H: Array, f: Array, A: Array, lower: Array, upper: Array, y: Array, multipliers: Array
) -> float:
    """Minimum over the box lower <= x <= upper of the Lagrangian, linearised at y.

    L(x) = 1/2 x'Hx + f'x + μ'(Ax - limits) is convex and below the objective wherever Ax is within its
    limits, so that L(y) + min g'(x - y), g = Hy + f + A'μ, is a bound.
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
