"""Residuals of a point and its multipliers, from the scaled problem alone.

Every residual is relative to the terms it is the sum of, so that neither units nor the size of the
problem matter: 1e-16 is round-off, 1e-8 is exact for every purpose of a robot.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tauten.controller.qpcc.scaling import Scaled, largest_magnitude
from tauten.model.numerics import Array, Bools, kernel

ACTIVE = 1e-8  # a limit this close, relative to its terms, may carry a multiplier
FLOOR = 1e-3  # gradient entries with terms smaller than this share of the largest count as that


@kernel
def row_values(problem: Scaled, z: Array) -> tuple[Array, Array]:
    """R z + r and the sum of the magnitudes of its terms: (rows,), (rows,)."""
    R = problem.R
    values, sizes = problem.r.copy(), np.abs(problem.r)
    for i in range(len(values)):
        for j in range(len(z)):
            if R[i, j] != 0.0:
                term = R[i, j] * z[j]
                values[i] += term
                sizes[i] += abs(term)
    return values, sizes


@kernel
def pair_values(problem: Scaled, z: Array, values: Array, sizes: Array) -> tuple[Array, Array]:
    """β and w of every pair, both relative to the terms of w: (k,), (k,)."""
    n_a = len(problem.lb)
    k = len(z) - n_a
    beta, w = np.zeros(k), np.zeros(k)
    for i in range(k):
        weight = pair_weight(problem, i)
        size = max(sizes[k + i], abs(weight * z[n_a + i]))
        if size > 0.0:
            beta[i] = weight * z[n_a + i] / size
            w[i] = values[k + i] / size
    return beta, w


@kernel
def pair_weight(problem: Scaled, i: int) -> float:
    """How far a unit of β_i moves w_i, to compare the two."""
    n_a = len(problem.lb)
    k = len(problem.c) - n_a
    weight = float(abs(problem.R[k + i, n_a + i]))
    if weight == 0.0:
        weight = largest_magnitude(problem.R[k + i])
    return weight


@kernel
def limit_residual(problem: Scaled, z: Array, values: Array, sizes: Array) -> float:
    """Largest violation of bounds and limits."""
    n_a = len(problem.lb)
    worst = 0.0
    for j in range(n_a):
        excess = max(problem.lb[j] - z[j], z[j] - problem.ub[j])
        if excess > 0.0:
            worst = max(worst, excess / (excess + abs(z[j])))
    for i in range(2 * (len(z) - n_a), len(values)):
        excess = max(problem.lo[i] - values[i], values[i] - problem.hi[i])
        if excess > 0.0:
            worst = max(worst, excess / (excess + sizes[i]))
    return worst


@kernel
def drop_inactive(
    problem: Scaled,
    z: Array,
    values: Array,
    sizes: Array,
    beta: Array,
    w: Array,
    alpha: Array,
    dual: Array,
) -> Bools:
    """Zero the multipliers of constraints that are not active, in place; which pairs are both zero."""
    n_a, k = len(alpha), len(beta)
    for j in range(n_a):
        if (alpha[j] > 0.0 and z[j] < problem.ub[j]) or (alpha[j] < 0.0 and z[j] > problem.lb[j]):
            alpha[j] = 0.0
    for i in range(2 * k, len(values)):
        lo, hi = problem.lo[i], problem.hi[i]
        if (dual[i] > 0.0 and values[i] < hi - ACTIVE * (sizes[i] + abs(hi))) or (
            dual[i] < 0.0 and values[i] > lo + ACTIVE * (sizes[i] + abs(lo))
        ):
            dual[i] = 0.0
    both = np.zeros(k, dtype=np.bool_)
    for i in range(k):
        if beta[i] > ACTIVE:
            dual[i] = 0.0
        elif w[i] > ACTIVE:
            dual[k + i] = 0.0
        else:
            both[i] = True
    return both


@kernel
def gradient_terms(problem: Scaled, z: Array, alpha: Array, dual: Array) -> tuple[Array, Array]:
    """Qz + c + (alpha, 0) + R'dual and the sum of the magnitudes of its terms: (n,), (n,)."""
    total, sizes = problem.c.copy(), np.abs(problem.c)
    for j in range(len(alpha)):
        total[j] += alpha[j]
        sizes[j] += abs(alpha[j])
    for i in range(len(z)):
        if z[i] != 0.0:
            for j in range(len(z)):
                term = problem.Q[i, j] * z[i]
                total[j] += term
                sizes[j] += abs(term)
    for i in range(len(dual)):
        if dual[i] != 0.0:
            for j in range(len(z)):
                term = problem.R[i, j] * dual[i]
                total[j] += term
                sizes[j] += abs(term)
    return total, sizes


@kernel
def objective_terms(problem: Scaled, z: Array) -> tuple[float, float]:
    """Objective without its constant, and the magnitude of the terms it is the sum of."""
    value, size = 0.0, 0.0
    for i in range(len(z)):
        slope = 0.0
        for j in range(len(z)):
            slope += problem.Q[i, j] * z[j]
        value += z[i] * (0.5 * slope + problem.c[i])
        size += abs(z[i]) * (0.5 * abs(slope) + abs(problem.c[i]))
    return value, size


class Residuals(NamedTuple):
    """What a point and its multipliers are worth.

    Attributes:
        objective: without the constant.
        terms: magnitude of the terms the objective is the sum of.
        primal: largest violation of bounds, limits and signs.
        complementarity: largest smaller side of a pair.
        stationarity: largest entry of the Lagrangian's gradient.
        gain: (k,) how much the objective falls, relative, when the side of a pair that the piece
            holds at zero is let go; above zero only where both sides are zero.
        largest_gain: of them.
    """

    objective: float
    terms: float
    primal: float
    complementarity: float
    stationarity: float
    gain: Array
    largest_gain: float


@kernel
def judge(problem: Scaled, z: Array, alpha: Array, dual: Array) -> Residuals:
    """Objective and residuals of a point (n,), its multipliers of bounds (n_a,) and rows (2k + p,)."""
    n_a = len(problem.lb)
    k = len(z) - n_a
    values, sizes = row_values(problem, z)
    beta, w = pair_values(problem, z, values, sizes)
    primal = limit_residual(problem, z, values, sizes)
    crossed = 0.0
    for i in range(k):
        primal = max(primal, -beta[i], -w[i])
        crossed = max(crossed, min(beta[i], w[i]))
    alpha, dual = alpha.copy(), dual.copy()
    both = drop_inactive(problem, z, values, sizes, beta, w, alpha, dual)
    total, terms = gradient_terms(problem, z, alpha, dual)
    floor = FLOOR * largest_magnitude(terms)
    stationarity, gain = 0.0, np.zeros(k)
    for j in range(len(z)):
        size = max(terms[j], floor)
        if size > 0.0:
            stationarity = max(stationarity, abs(total[j]) / size)
            i = j - n_a
            if i >= 0 and both[i]:
                gain[i] = max(dual[i], dual[k + i] * pair_weight(problem, i), 0.0) / size
    objective, magnitude = objective_terms(problem, z)
    if not magnitude < np.inf:  # max() above passes over a NaN, this does not
        primal = np.inf
    largest = largest_magnitude(gain)
    return Residuals(objective, magnitude, primal, crossed, stationarity, gain, largest)
