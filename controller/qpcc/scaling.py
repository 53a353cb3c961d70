"""A QPCC without units, which is what the solver works on.

Compliances are around 1e-4 m/N and objectives around 1e-6 m², far from the order of one that tolerances of
QP solvers expect. Forces are measured in units that make the diagonal of the contact compliance one, limits
in units that make the largest entry of their rows one, all powers of two, so that nothing is rounded.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tauten.controller.qpcc.problem import Qpcc, QpccArrays
from tauten.controller.qpcc.qp import UNBOUNDED
from tauten.model.numerics import Array, kernel

USABLE, CROSSED_LIMITS, NOT_FINITE = 0, 1, 2  # the larger one counts
FLAT = 1e-12  # a curvature this far below the slope is none, and it is the slope that becomes one


class Scaled(NamedTuple):
    """A QPCC without units, all constraints but the bounds on a as rows of one matrix.

        R = (β; M; G),   lo <= R z + r <= hi,   r = (0; m; 0)                              (4)

    A tuple, because kernels take tuples as they are.

    Attributes:
        Q: (n, n).
        c: (n,).
        lb: (n_a,), at least -UNBOUNDED.
        ub: (n_a,), at most UNBOUNDED.
        R: (2k + p, n).
        r: (2k + p,).
        lo: (2k + p,), zero for the first 2k.
        hi: (2k + p,), UNBOUNDED for the first 2k.
    """

    Q: Array
    c: Array
    lb: Array
    ub: Array
    R: Array
    r: Array
    lo: Array
    hi: Array


class Units(NamedTuple):
    """The units of a scaled problem: those of z (n,) and that of the objective."""

    column: Array
    cost: float


def scale(problem: Qpcc) -> tuple[int, Scaled, Units]:
    """Whether the numbers are USABLE, NOT_FINITE or CROSSED_LIMITS, and the problem without units."""
    arrays = problem.arrays
    scaled, column = space_for(arrays)
    numbers, cost = scale_into(arrays, scaled, column)
    return numbers, scaled, Units(column, cost)


def space_for(problem: QpccArrays) -> tuple[Scaled, Array]:
    """Memory for a problem without units, and for the units of z (n,)."""
    n_a, n, rows = len(problem.lb), len(problem.c), 2 * len(problem.m) + len(problem.G)
    bounds, limits = (np.empty(n_a), np.empty(n_a)), (np.empty(rows), np.empty(rows))
    R, r = np.empty((rows, n)), np.empty(rows)
    return Scaled(np.empty((n, n)), np.empty(n), *bounds, R, r, *limits), np.empty(n)


@kernel
def scale_into(problem: QpccArrays, scaled: Scaled, column: Array) -> tuple[int, float]:
    """Write a problem without units; whether it is USABLE, and the unit of the objective.

    Args:
        problem: the arrays of a `Qpcc`.
        scaled: output, from `space_for`.
        column: output (n,), the units of z.
    """
    Q, c, lb, ub, G, g_lo, g_hi, M, m = problem
    lower, upper, R, r, lo, hi = scaled.lb, scaled.ub, scaled.R, scaled.r, scaled.lo, scaled.hi
    n_a, k = len(lb), len(m)
    column[:] = column_units(Q, G, M, n_a)
    R[:], r[:], lo[:], hi[:] = scaled_rows(column, G, g_lo, g_hi, M, m)
    for i in range(n_a + k):
        for j in range(n_a + k):
            scaled.Q[i, j] = 0.5 * (Q[i, j] + Q[j, i]) * column[i] * column[j]
    curvature, slope = largest_magnitude(np.diag(scaled.Q)), largest_magnitude(c * column)
    factor = unit(curvature if curvature > FLAT * slope else slope)
    scaled.Q[:] *= factor
    scaled.c[:] = c * column * factor
    for j in range(n_a):
        lower[j], upper[j] = cut(lb[j] / column[j]), cut(ub[j] / column[j])
    finite = total(Q, c) + total(G, c) + total(M, m) + total(scaled.Q, scaled.c) + total(R, r)
    # a sum is finite unless something in it is not, or it overflows, which is as useless; and not
    # np.isfinite, because where sums may be reordered LLVM takes its x - x for zero
    numbers = USABLE if finite < np.inf else NOT_FINITE
    if has_nan(lb) or has_nan(ub) or has_nan(g_lo) or has_nan(g_hi):
        numbers = NOT_FINITE
    elif not (in_order(lb, ub, np.inf) and in_order(g_lo, g_hi, np.inf)):
        numbers = max(numbers, CROSSED_LIMITS)
    elif not (in_order(lower, upper, UNBOUNDED) and in_order(lo, hi, UNBOUNDED)):
        numbers = NOT_FINITE  # a lower limit beyond UNBOUNDED is no number to compute with
    return numbers, 1.0 / factor


@kernel
def has_nan(values: Array) -> bool:
    """Whether an entry is NaN."""
    found = False
    for i in range(len(values)):
        found = found or np.isnan(values[i])
    return found


@kernel
def scaled_rows(
    column: Array, G: Array, g_lo: Array, g_hi: Array, M: Array, m: Array
) -> tuple[Array, Array, Array, Array]:
    """R, r, lo, hi of `Scaled`.

    Args:
        column: (n,) units of z.
        G: (p, n) rows of the limits.
        g_lo: (p,) lower limits.
        g_hi: (p,) upper limits.
        M: (k, n) complementarity rows.
        m: (k,) constants of these rows.
    """
    k, p, n = len(m), len(g_lo), len(column)
    R, r = np.zeros((2 * k + p, n)), np.zeros(2 * k + p)
    lo, hi = np.zeros(2 * k + p), np.full(2 * k + p, UNBOUNDED)
    for i in range(k):
        unit_of_i = column[n - k + i]
        R[i, n - k + i] = 1.0
        for j in range(n):
            R[k + i, j] = unit_of_i * M[i, j] * column[j]
        r[k + i] = unit_of_i * m[i]
    for i in range(p):
        row = G[i] * column
        factor = unit(largest_magnitude(row))
        R[2 * k + i] = row * factor
        lo[2 * k + i], hi[2 * k + i] = cut(g_lo[i] * factor), cut(g_hi[i] * factor)
    return R, r, lo, hi


@kernel
def cut(limit: float) -> float:
    """A limit, at most UNBOUNDED in magnitude."""
    return min(max(limit, -UNBOUNDED), UNBOUNDED)


@kernel
def total(matrix: Array, vector: Array) -> float:
    """Sum of all magnitudes."""
    value = 0.0
    for j in range(len(vector)):
        value += abs(vector[j])
    for i in range(matrix.shape[0]):
        for j in range(matrix.shape[1]):
            value += abs(matrix[i, j])
    return value


@kernel
def in_order(lower: Array, upper: Array, end: float) -> bool:
    """Whether a number between -end and end fits between each pair of limits.

    Args:
        lower: (m,) lower limits.
        upper: (m,) upper limits.
        end: magnitude that the number must be below.
    """
    fits = True
    for i in range(len(lower)):
        fits = fits and lower[i] <= upper[i] and lower[i] < end and upper[i] > -end
    return fits


@kernel
def unit(size: float) -> float:
    """The power of two nearest to 1 / size; 1 when there is none."""
    if not (1e-200 < size < 1e200):
        return 1.0
    return float(np.exp2(-np.rint(np.log2(size))))


@kernel
def largest_magnitude(values: Array) -> float:
    """Of the entries, 0 when there are none."""
    largest = 0.0
    for i in range(len(values)):
        largest = max(largest, abs(values[i]))
    return largest


@kernel
def column_units(Q: Array, G: Array, M: Array, n_a: int) -> Array:
    """Units of z: one of β_i moves its own gap by about one, one of a_j a contact or a limit.

    Args:
        Q: (n, n) Hessian [m²/N²].
        G: (p, n) rows of the limits.
        M: (k, n) complementarity rows [m/N].
        n_a: number of tensions.
    """
    n = Q.shape[0]
    column = np.ones(n)
    for i in range(n - n_a):
        size = abs(M[i, n_a + i])
        if size == 0.0:
            size = largest_magnitude(M[i])
        column[n_a + i] = unit(np.sqrt(size))
    for j in range(n_a):
        size = 0.0
        for i in range(len(M)):
            size = max(size, abs(M[i, j]) * column[n_a + i])
        if size == 0.0:
            size = largest_magnitude(G[:, j])
        if size == 0.0:
            size = np.sqrt(abs(Q[j, j]))
        column[j] = unit(size)
    return column
