"""Residuals of a solution from the problem alone, whichever solver made it.

Every residual is relative to the terms it is the sum of, so that neither units nor the size of the problem
matter: 1e-16 is round-off, 1e-8 is exact for every purpose of a robot.
"""

from __future__ import annotations

import numpy as np
from tauten.model.arrays import Array, Bools
from tauten.model.jit import kernel

ACTIVE = 1e-8  # a limit this close, relative to its terms, may carry a multiplier


@kernel
def row_values(R: Array, r: Array, z: Array) -> tuple[Array, Array]:
    """R z + r and the sum of the magnitudes of its terms: (rows,), (rows,)."""
    values, sizes = r.copy(), np.abs(r)
    for i in range(len(r)):
        for j in range(len(z)):
            term = R[i, j] * z[j]
            values[i] += term
            sizes[i] += abs(term)
    return values, sizes


@kernel
def pair_scales(R: Array, sizes: Array, k: int, n_a: int) -> tuple[Array, Array]:
    """What β_i is multiplied with to compare with w_i, and the magnitude of both: (k,), (k,)."""
    weight = np.empty(k)
    for i in range(k):
        weight[i] = abs(R[k + i, n_a + i])
        if weight[i] == 0.0:
            weight[i] = np.max(np.abs(R[k + i]))
    return weight, sizes[k : 2 * k].copy()


@kernel
def gradient_sizes(
    Q: Array, c: Array, R: Array, z: Array, alpha: Array, dual: Array
) -> tuple[Array, Array]:
    """Qz + c + (alpha, 0) + R'dual and the sum of the magnitudes of its terms: (n,), (n,)."""
    total, sizes = c.copy(), np.abs(c)
    for j in range(len(alpha)):
        total[j] += alpha[j]
        sizes[j] += abs(alpha[j])
    for i in range(len(z)):
        for j in range(len(z)):
            term = Q[i, j] * z[i]
            total[j] += term
            sizes[j] += abs(term)
    for i in range(len(dual)):
        if dual[i] != 0.0:
            for j in range(len(z)):
                term = R[i, j] * dual[i]
                total[j] += term
                sizes[j] += abs(term)
    return total, sizes


@kernel
def judge(
    Q: Array, c: Array, lb: Array, ub: Array, R: Array, r: Array, lo: Array, hi: Array,
    z: Array, alpha: Array, dual: Array,
) -> tuple[float, float, float, Bools]:  # fmt: skip
    """Residuals of a point and its multipliers, and the pairs whose multipliers have the wrong sign.

    Wrong (k,): both β_i and w_i are zero, and the multiplier of the one that the piece fixes says that
    the objective falls when it is let go. Without any, and with small residuals, the point is strongly
    stationary.

    Returns:
        Primal, complementarity and stationarity residuals, and the wrong pairs.
    """
    n_a = len(lb)
    k = len(z) - n_a
    values, sizes = row_values(R, r, z)
    weight, scale = pair_scales(R, sizes, k, n_a)
    primal, crossed = 0.0, 0.0
    for j in range(n_a):
        excess = max(lb[j] - z[j], z[j] - ub[j])
        if excess > 0.0:
            primal = max(primal, excess / (excess + abs(z[j])))
    wrong = np.zeros(k, dtype=np.bool_)
    for i in range(k):
        beta, w = z[n_a + i] * weight[i], values[k + i]
        if scale[i] > 0.0:
            primal = max(primal, -beta / scale[i], -w / scale[i])
            crossed = max(crossed, min(beta, w) / scale[i])
        pushes, is_open = beta > ACTIVE * scale[i], w > ACTIVE * scale[i]
        if pushes:
            dual[i] = 0.0
        elif is_open:
            dual[k + i] = 0.0
        wrong[i] = not pushes and not is_open
    for i in range(2 * k, len(r)):
        excess = max(lo[i] - values[i], values[i] - hi[i])
        if excess > 0.0:
            primal = max(primal, excess / (excess + sizes[i]))
        if dual[i] > 0.0 and values[i] < hi[i] - ACTIVE * (sizes[i] + abs(hi[i])):
            dual[i] = 0.0
        if dual[i] < 0.0 and values[i] > lo[i] + ACTIVE * (sizes[i] + abs(lo[i])):
            dual[i] = 0.0
    for j in range(n_a):
        if (alpha[j] > 0.0 and z[j] < ub[j]) or (alpha[j] < 0.0 and z[j] > lb[j]):
            alpha[j] = 0.0
    total, terms = gradient_sizes(Q, c, R, z, alpha, dual)
    floor = 1e-3 * np.max(terms) if len(terms) > 0 else 0.0
    stationarity = 0.0
    for j in range(len(z)):
        size = max(terms[j], floor)
        if size > 0.0:
            stationarity = max(stationarity, abs(total[j]) / size)
        if j >= n_a:
            i = j - n_a
            tolerance = ACTIVE * size
            wrong[i] = wrong[i] and (dual[i] > tolerance or dual[k + i] * weight[i] > tolerance)
    return primal, crossed, stationarity, wrong
