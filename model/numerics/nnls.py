"""Non-negative least squares, by the active set of `tauten.model.numerics.active_set`.

`coordinates` solves many small problems with one matrix exactly, from one Gram matrix (k, k) with k of tens.
`sparse_nnls` solves one problem with thousands of columns, whose Gram matrix would be too large, and ends
before the optimum to keep the solution sparse.
"""

from __future__ import annotations

import numpy as np

from tauten.model.numerics.active_set import active_set_forces, solve_on_set
from tauten.model.numerics.arrays import Array
from tauten.model.numerics.updated_cholesky import append_row

# Added to the unit diagonal of ΨᵀΨ: makes every active set solvable when columns are linearly
# dependent; what it changes is mended at the end.
_RIDGE = 1e-10
_FLOOR = 1e-12  # against rounding in the factor of unit columns
_NOTHING = 1e-10  # a gain this small, relative to d, is rounding


def coordinates(Psi: Array, S: Array) -> Array:
    """B (k, s) ≥ 0 that minimises ‖S − Ψ B‖_F: the points of cone(Ψ) nearest to the columns of S (n_c, s).

    The generators Ψ (n_c, k) of the cone have no column of zeros.

    Source: Lawson and Hanson, Solving Least Squares Problems, 1974, chapter 23, on the Gram matrix
    as in Bro and de Jong, Journal of Chemometrics 11, 1997.
    """
    scale = np.linalg.norm(Psi, axis=0)  # (k,)
    unit = Psi / scale
    gram = unit.T @ unit  # (k, k)
    moments = np.ascontiguousarray((unit.T @ S).T)  # (s, k)
    nothing = np.zeros(len(scale))
    B = [active_set_forces(gram, -one, nothing, _RIDGE, 10 * len(scale))[0] for one in moments]
    coefficients: Array = np.reshape(B, moments.shape).T / scale[:, None]  # (k, s)
    return coefficients


def distances(Psi: Array, S: Array) -> Array:
    """Distance of every column of S to cone(Ψ): (s,), in the unit of S; see `coordinates`."""
    distance: Array = np.linalg.norm(S - Psi @ coordinates(Psi, S), axis=0)
    return distance


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
    usable = norms > _NOTHING * norms.max(initial=0.0)
    unit = np.ascontiguousarray((C / np.where(usable, norms, 1.0)).T)  # (e, m), a row a column of C
    size, limit = float(np.linalg.norm(d)), min(C.shape)
    slopes, ones = -(unit @ d), np.ones(len(norms))  # (e,)
    w, active, f = np.zeros(len(norms)), np.zeros(limit, dtype=np.int64), 0
    inside, excluded = np.zeros(len(norms), dtype=bool), ~usable
    L, residual = np.zeros((limit, limit)), d.copy()
    while float(np.linalg.norm(residual)) > tolerance * size and f < limit:
        gain = np.where(inside | excluded, -np.inf, unit @ residual)  # (e,)
        best = int(np.argmax(gain))
        if not gain[best] > _NOTHING * size:
            break
        append_row(L, f, unit[active[:f]] @ unit[best], 1.0, _FLOOR)
        active[f], inside[best] = best, True
        f = solve_on_set(slopes, ones, L, active, f + 1, w, inside)
        excluded = ~usable if inside[best] else excluded | (np.arange(len(w)) == best)
        residual = d - w[active[:f]] @ unit[active[:f]]
    return np.where(usable, w / np.where(usable, norms, 1.0), 0.0)
