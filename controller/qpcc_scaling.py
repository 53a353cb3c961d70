"""Units out of a QPCC: the scaled problem the solver works on, and the way back.

Compliances are around 1e-4 m/N and objectives around 1e-6 m², far from the order of one that tolerances of
QP solvers expect. Forces are measured in units that make the diagonal of the contact compliance one, limits
in units that make their rows have norm one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from tauten.controller.qp import UNBOUNDED
from tauten.model.arrays import Array
from tauten.model.jit import kernel


@dataclass(frozen=True, slots=True)
class Scaled:
    """A QPCC in the form (4) of `qpcc_pieces`, z = column * z_scaled.

    Attributes:
        Q: (n, n).
        c: (n,).
        lb: (n_a,), at least -UNBOUNDED.
        ub: (n_a,).
        R: (2k + p, n) rows β, M, G.
        r: (2k + p,).
        lo: (2k + p,).
        hi: (2k + p,).
        column: (n,) units of z.
        cost: unit of the objective.
    """

    Q: Array
    c: Array
    lb: Array
    ub: Array
    R: Array
    r: Array
    lo: Array
    hi: Array
    column: Array
    cost: float

    @property
    def k(self) -> int:
        """Modes."""
        return len(self.c) - len(self.lb)

    def objective(self, z: Array) -> float:
        """Of a scaled point, in units of `cost`."""
        return float(z @ (0.5 * (self.Q @ z) + self.c))


@kernel
def equilibrate(
    Q: Array, c: Array, lb: Array, ub: Array, G: Array, g_lo: Array, g_hi: Array, M: Array, m: Array
) -> tuple[
    Array, Array, Array, Array, Array, Array, Array, Array, Array, float
]:  # fmt: skip
    """Arrays of `Scaled`."""
    n, n_a, k, p = len(c), len(lb), len(m), len(g_lo)
    column = np.ones(n)
    for i in range(k):
        size = abs(M[i, n_a + i])
        if size == 0.0:
            size = np.max(np.abs(M[i]))
        column[n_a + i] = unit(1.0 / np.sqrt(size)) if size > 0.0 else 1.0
    for j in range(n_a):
        column[j] = column_unit(Q, G, M, column, n_a, j)
    R, r = np.zeros((2 * k + p, n)), np.zeros(2 * k + p)
    lo, hi = np.zeros(2 * k + p), np.full(2 * k + p, UNBOUNDED)
    for i in range(k):
        R[i, n_a + i] = 1.0
        scale_row(M[i], column, R[k + i], column[n_a + i])
        r[k + i] = m[i] * column[n_a + i]
    for i in range(p):
        factor = scale_row(G[i], column, R[2 * k + i], 0.0)
        lo[2 * k + i], hi[2 * k + i] = limit(g_lo[i] * factor), limit(g_hi[i] * factor)
    largest = 0.0
    for j in range(n):
        largest = max(largest, abs(Q[j, j]) * column[j] ** 2)
    cost = 1.0 / largest if largest > 0.0 else 1.0
    cost = cost if np.isfinite(cost) else 1.0
    scaled_Q, scaled_c = np.empty((n, n)), np.empty(n)
    for i in range(n):
        scaled_c[i] = cost * column[i] * c[i]
        for j in range(n):
            scaled_Q[i, j] = cost * column[i] * (0.5 * (Q[i, j] + Q[j, i])) * column[j]
    scaled_lb, scaled_ub = np.empty(n_a), np.empty(n_a)
    for j in range(n_a):
        scaled_lb[j], scaled_ub[j] = limit(lb[j] / column[j]), limit(ub[j] / column[j])
    return scaled_Q, scaled_c, scaled_lb, scaled_ub, R, r, lo, hi, column, 1.0 / cost


@kernel
def unit(size: float) -> float:
    """The next power of two, so that scaling rounds nothing; 1 when there is none."""
    if not np.isfinite(size) or size <= 0.0:
        return 1.0
    result: float = 2.0 ** np.round(np.log2(size))
    return result


@kernel
def limit(value: float) -> float:
    """Clip an infinite limit to what the QP module calls unbounded."""
    return min(max(value, -UNBOUNDED), UNBOUNDED)


@kernel
def scale_row(row: Array, column: Array, out: Array, factor: float) -> float:
    """`out` = factor * row * column; factor 0: what makes the largest entry about one. Returns it."""
    for j in range(len(row)):
        out[j] = row[j] * column[j]
    if factor == 0.0:
        largest = np.max(np.abs(out))
        factor = unit(1.0 / largest) if largest > 0.0 else 1.0
    for j in range(len(row)):
        out[j] *= factor
    return factor


@kernel
def column_unit(Q: Array, G: Array, M: Array, column: Array, n_a: int, j: int) -> float:
    """Unit of tension j: what moves a contact, else a limit, else the objective by about one."""
    largest = 0.0
    for i in range(len(M)):
        largest = max(largest, abs(M[i, j]) * column[n_a + i])
    if largest == 0.0:
        for i in range(len(G)):
            largest = max(largest, abs(G[i, j]))
    if largest == 0.0:
        largest = np.sqrt(abs(Q[j, j]))
    return unit(1.0 / largest) if largest > 0.0 else 1.0
