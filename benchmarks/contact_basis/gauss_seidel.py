"""Projected Gauss-Seidel, the method of the paper (13), which reduced contact is compared with."""

from __future__ import annotations

import numpy as np

from tauten.model.numerics import Array, LcpResult, complementarity, kernel


def solve_pgs(
    W: Array,
    delta_free: Array,
    start: Array | None = None,
    tolerance: float = 1e-9,
    max_sweeps: int = 10_000,
) -> LcpResult:
    """Solve 0 ≤ δ ⟂ λ ≥ 0 by projected Gauss-Seidel (13).

    Converges linearly, and slowly where many candidates act on few nodes.

    Args:
        W: (m, m) compliance [m/N].
        delta_free: (m,) gaps without forces [m].
        start: (m,) forces to start from; with a rank-deficient W the result depends on them.
        tolerance: residual that counts as solved [m].
        max_sweeps: sweeps over all rows at most.
    """
    begin = np.zeros_like(delta_free) if start is None else start
    W = np.ascontiguousarray(W)
    lam, sweeps = gauss_seidel(W, delta_free, begin, tolerance, max_sweeps)
    delta = delta_free + W @ lam
    residual = complementarity(W, lam, delta)
    return LcpResult(lam, delta, residual, sweeps, residual <= tolerance)


@kernel
def gauss_seidel(
    W: Array, delta_free: Array, start: Array, tolerance: float, max_sweeps: int
) -> tuple[Array, int]:
    """Forces (m,) and the number of sweeps of `solve_pgs`.

    The change w_ii Δλ_i of a row is its residual min(w_ii λ_i, δ_i) at that moment, so that a sweep yields an
    estimate of the residual; before the loop ends it is checked with newly computed gaps.

    Args:
        W: (m, m) compliance.
        delta_free: (m,) gaps without force.
        start: (m,) forces to start from.
        tolerance: largest residual of a solution.
        max_sweeps: sweeps at most.
    """
    n = delta_free.shape[0]
    lam = start.copy()
    delta = delta_free + W @ lam
    for sweep in range(max_sweeps):
        largest = 0.0
        for i in range(n):
            if W[i, i] <= 0.0:  # no force moves this row
                continue
            change = max(-delta[i] / W[i, i], -lam[i])
            if change != 0.0:
                lam[i] += change
                delta += change * W[i]
                largest = max(largest, abs(W[i, i] * change))
        if largest <= tolerance:
            delta = delta_free + W @ lam
            residual = 0.0
            for i in range(n):
                if W[i, i] > 0.0:
                    residual = max(residual, abs(min(W[i, i] * lam[i], delta[i])))
            if residual <= tolerance:
                return lam, sweep + 1
    return lam, max_sweeps
