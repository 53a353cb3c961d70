"""Nearest points of the cone {Ψ β, β ≥ 0}: many small nonnegative least-squares problems with one matrix.

The exact solutions of all problems come from one Gram matrix (k, k), with k of tens. The other solver,
`tauten.model.numerics.early_stopped_nnls`, solves one problem with thousands of columns, whose Gram matrix
would be too large, and ends before the optimum to keep the solution sparse.
"""

from __future__ import annotations

import numpy as np

from tauten.model.numerics.arrays import Array, Bools
from tauten.model.numerics.jit import kernel

# Added to the unit diagonal of ΨᵀΨ: makes every passive set solvable when columns are linearly
# dependent, and changes the residual by about its square root, 1e-6 of the column.
_RIDGE = 1e-12


def coordinates(Psi: Array, S: Array) -> Array:
    """Coefficients B ≥ 0 of the points of cone(Ψ) nearest to the columns of S.

    Args:
        Psi: (n_c, k) generators of the cone, nonzero columns.
        S: (n_c, s) columns to project.

    Returns:
        (k, s) B = argmin over B ≥ 0 of ‖S − Ψ B‖_F.

    Source: Lawson and Hanson, Solving Least Squares Problems, 1974, chapter 23, on the Gram matrix
    as in Bro and de Jong, Journal of Chemometrics 11, 1997.
    """
    scale = np.linalg.norm(Psi, axis=0)  # (k,)
    unit = Psi / scale
    gram = unit.T @ unit + _RIDGE * np.eye(len(scale))  # (k, k)
    target = np.ascontiguousarray((unit.T @ S).T)  # (s, k)
    B = np.zeros_like(target)  # (s, k)
    for j in range(len(B)):
        _nnls(gram, target[j], B[j])
    coefficients: Array = np.ascontiguousarray(B.T) / scale[:, None]  # (k, s)
    return coefficients


def distances(Psi: Array, S: Array) -> Array:
    """Distance of every column of S to cone(Ψ): (s,), in the unit of S; see `coordinates`."""
    distance: Array = np.linalg.norm(S - Psi @ coordinates(Psi, S), axis=0)
    return distance


@kernel
def _nnls(gram: Array, target: Array, x: Array) -> None:
    """Lawson-Hanson on the normal equations; x (k,) is zero on entry and the solution on return."""
    k = len(target)
    passive = np.zeros(k, dtype=np.bool_)
    tolerance = 1e-13 * np.max(np.abs(target))
    for _ in range(10 * k):  # 3 k is the usual limit; at the limit x is feasible, not optimal
        slope = target - gram @ x  # (k,)
        slope[passive] = -np.inf
        enter = np.argmax(slope)
        if slope[enter] <= tolerance:
            return
        passive[enter] = True
        _descend(gram, target, x, passive)


@kernel
def _descend(gram: Array, target: Array, x: Array, passive: Bools) -> None:
    """Minimise over the passive coefficients, removing those that would become negative."""
    while passive.any():
        index = np.flatnonzero(passive)
        z = np.linalg.solve(gram[index][:, index], target[index])
        if z.min() > 0.0:
            x[index] = z
            return
        step = 1.0
        leaves = index[np.argmin(z)]
        for i in range(len(z)):
            way = max(x[index[i]] - z[i], 1e-300)
            if z[i] <= 0.0 and x[index[i]] <= step * way:
                step, leaves = x[index[i]] / way, index[i]
        x[index] += step * (z - x[index])
        x[leaves] = 0.0
        passive[leaves] = False
