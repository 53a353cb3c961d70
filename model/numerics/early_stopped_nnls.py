"""Nonnegative least squares with few nonzeros: ends as soon as the residual is small enough.

It solves one problem with thousands of columns and a sparse solution, by single rows of a Cholesky factor of
the active columns only. For many small problems with one matrix, solved to the optimum, see
`tauten.model.numerics.nnls`.
"""

from __future__ import annotations

import numpy as np

from tauten.model.numerics.arrays import Array, Bools, Ints
from tauten.model.numerics.jit import kernel
from tauten.model.numerics.updated_cholesky import (
    append_row,
    back_substitute,
    delete_row,
    forward_substitute,
)

FLOOR = 1e-12  # against rounding in the factor of unit columns
NOTHING = 1e-10  # a gain this small, relative to d, is rounding


def sparse_nnls(C: Array, d: Array, tolerance: float) -> Array:
    """Weights w ≥ 0 with ‖C w − d‖ ≤ tolerance ‖d‖, few of them positive: (e,).

    The active set of Lawson and Hanson (1974) adds columns greedily; ended early, it has few of them
    (Farhat, Avery, Chapman, Cortial, Int. J. Numerical Methods in Engineering 98, 2014). The factor of the
    active Gram matrix is updated by single rows (as in Chapman, Avery, Collins, Farhat, ibid. 109, 2017).

    Args:
        C: (m, e) contributions.
        d: (m,) their weighted sum, in the unit of C.
        tolerance: relative residual at which to end; the result's is larger where d is too far from the cone.
    """
    norms = np.linalg.norm(C, axis=0)  # (e,)
    usable = norms > NOTHING * norms.max(initial=0.0)
    unit = np.ascontiguousarray((C / np.where(usable, norms, 1.0)).T)  # (e, m), a row a column of C
    size, limit = float(np.linalg.norm(d)), min(C.shape)
    moments = unit @ d  # (e,)
    w, active, f = np.zeros(len(norms)), np.zeros(limit, dtype=np.int64), 0
    inside, excluded = np.zeros(len(norms), dtype=bool), ~usable
    L, residual = np.zeros((limit, limit)), d.copy()
    while float(np.linalg.norm(residual)) > tolerance * size and f < limit:
        gain = np.where(inside | excluded, -np.inf, unit @ residual)  # (e,)
        best = int(np.argmax(gain))
        if not gain[best] > NOTHING * size:
            break
        append_row(L, f, unit[active[:f]] @ unit[best], 1.0, FLOOR)
        active[f], inside[best] = best, True
        f = solve_on_active(L, active, f + 1, moments, w, inside)
        excluded = ~usable if inside[best] else excluded | (np.arange(len(w)) == best)
        residual = d - w[active[:f]] @ unit[active[:f]]
    return np.where(usable, w / np.where(usable, norms, 1.0), 0.0)


@kernel
def solve_on_active(L: Array, active: Ints, f: int, moments: Array, w: Array, inside: Bools) -> int:
    """Move w to the least-squares solution on the active columns; columns that become negative are removed.

    Args:
        L: (limit, limit) Cholesky factor of the active Gram matrix, updated.
        active: (limit,) numbers of the active columns, updated.
        f: number of active columns.
        moments: (e,) products of the columns with d.
        w: (e,) weights, updated.
        inside: (e,) whether a column is active, updated.

    Returns:
        Number of active columns.
    """
    while f > 0:
        y = np.empty(f)
        for k in range(f):
            y[k] = moments[active[k]]
        forward_substitute(L, f, y)
        back_substitute(L, f, y)
        share, blocking = 1.0, -1  # largest step towards y at which all weights are positive
        for k in range(f):
            if y[k] <= 0.0:
                here = w[active[k]] / (w[active[k]] - y[k]) if w[active[k]] > 0.0 else 0.0
                if here < share or blocking < 0:
                    share, blocking = min(here, share), k
        for k in range(f):
            w[active[k]] += share * (y[k] - w[active[k]])
        if blocking < 0:
            return f
        w[active[blocking]] = 0.0
        for k in range(f - 1, -1, -1):
            if w[active[k]] <= 0.0:
                w[active[k]], inside[active[k]] = 0.0, False
                delete_row(L, f, k)
                active[k : f - 1] = active[k + 1 : f].copy()
                f -= 1
    return f
