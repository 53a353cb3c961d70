"""Nonnegative matrix factorisation S ≈ Ψ B, Ψ ≥ 0, B ≥ 0 (17): the paper's ALS, and HALS.

Every function takes a snapshot matrix S (n_c, s) ≥ 0 that `factorise` has checked, and returns
(Ψ (n_c, k), B (k, s)).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tauten.model.numerics import Array, kernel

Factors = tuple[Array, Array]

# A relative decrease below 1e-4 is smaller than the error of a mode that is out of range; 100 iterations
# limit the time for each k.
TOLERANCE = 1e-4
MAX_ITERATIONS = 100
_SWEEPS = 10  # passes over one factor with the other one fixed (Gillis and Glineur 2012)


def als(S: Array, k: int, seed: int) -> Factors:
    """Alternating least squares, exactly Algorithm 1 of the paper.

    Setting the negative entries of the unconstrained least-squares solution to zero is no projection: the
    error may increase from one iteration to the next and from one k to a larger one. Columns that become
    zero are returned as zeros.

    Args:
        S: (n_c, s) snapshots.
        k: number of columns of Ψ.
        seed: of the random start.

    Source: Goury, Carrez, Duriez, IEEE RA-L, Algorithm 1.
    """
    rng = np.random.default_rng(seed)
    Psi = rng.random((S.shape[0], k))  # (n_c, k)
    B = np.zeros((k, S.shape[1]))
    before = np.inf
    for _ in range(2 * MAX_ITERATIONS):
        # lstsq equals `solve` for a regular matrix and also works with zero columns
        B = np.maximum(np.linalg.lstsq(Psi.T @ Psi, Psi.T @ S, rcond=None)[0], 0.0)  # (k, s)
        Psi = np.maximum(np.linalg.lstsq(B @ B.T, B @ S.T, rcond=None)[0].T, 0.0)  # (n_c, k)
        error = relative_error(S, Psi, B)
        if abs(before - error) <= TOLERANCE * error:
            break
        before = error
    return Psi, B


def hals(S: Array, k: int) -> Iterator[Factors]:
    """HALS of S (n_c, s) with one column added at a time; yields the factors for 1, 2, … k columns.

    From k − 1 columns to k: append the leading nonnegative part of the residual, then run HALS from there.
    Its error never increases, so error(k) ≤ error(k − 1) by construction, and one run gives the whole curve
    of error against k. There is no random start, so no seed.

    Source: Cichocki and Phan, IEICE Trans. Fundamentals E92-A, 2009 (HALS); the new column is the
    first step of NNDSVD (see `hals_nndsvd`) applied to the residual.
    """
    Psi, B = np.zeros((S.shape[0], 0)), np.zeros((0, S.shape[1]))
    for _ in range(k):
        column, row = leading_part(*_leading_pair(S - Psi @ B))
        Psi, B = descend(S, np.c_[Psi, column], np.r_[B, row[None]])
        yield Psi, B


def hals_nndsvd(S: Array, k: int) -> Factors:
    """HALS from the NNDSVD start of all k columns at once.

    Source: Boutsidis and Gallopoulos, Pattern Recognition 41, 2008 (NNDSVD).
    """
    U, sigma, Vt = np.linalg.svd(S, full_matrices=False)  # (n_c, r), (r,), (r, s)
    parts = [leading_part(sigma[i] * U[:, i], Vt[i]) for i in range(k)]
    return descend(S, np.stack([p[0] for p in parts], axis=1), np.stack([p[1] for p in parts]))


def descend(S: Array, Psi: Array, B: Array) -> Factors:
    """HALS: exact minimisation over one column or row after the other.

    Args:
        S: (n_c, s) snapshots.
        Psi: (n_c, k) start.
        B: (k, s) start.

    Source: Gillis and Glineur, Neural Computation 24, 2012 (several passes over one factor before
    the products with S, the most expensive part, are computed again).
    """
    Psi, Bt = np.ascontiguousarray(Psi), np.ascontiguousarray(B.T)  # (n_c, k), (s, k)
    before = np.inf
    for _ in range(MAX_ITERATIONS):
        _minimise(Bt, S.T @ Psi, Psi.T @ Psi)
        _minimise(Psi, S @ Bt, Bt.T @ Bt)
        error = relative_error(S, Psi, Bt.T)
        if before - error <= TOLERANCE * error:
            break
        before = error
    return Psi, np.ascontiguousarray(Bt.T)


def leading_part(u: Array, v: Array) -> tuple[Array, Array]:
    """The nonnegative rank-one part of u vᵀ with the larger norm, split evenly: (n_c,), (s,).

    That is the positive parts of u and v, or of −u and −v: a change of sign of both, which a
    singular value decomposition leaves open, makes no difference.
    """
    pairs = [(np.maximum(sign * u, 0.0), np.maximum(sign * v, 0.0)) for sign in (1.0, -1.0)]
    norms = [np.linalg.norm(a) * np.linalg.norm(b) for a, b in pairs]
    column, row = pairs[int(norms[1] > norms[0])]
    weight = np.sqrt(max(norms))
    return weight * _unit(column), weight * _unit(row)


def relative_error(S: Array, Psi: Array, B: Array) -> float:
    """‖S − Ψ B‖_F / ‖S‖_F.

    Args:
        S: (n_c, s) snapshots.
        Psi: (n_c, k) modes.
        B: (k, s) coefficients.
    """
    return float(np.linalg.norm(S - Psi @ B) / np.linalg.norm(S))


def _leading_pair(R: Array) -> tuple[Array, Array]:
    """Leading singular pair σ u (n_c,), v (s,) of R (n_c, s), from the smaller Gram matrix."""
    if R.shape[0] <= R.shape[1]:
        u: Array = np.linalg.eigh(R @ R.T)[1][:, -1]
        return u, R.T @ u
    v: Array = np.linalg.eigh(R.T @ R)[1][:, -1]
    return R @ v, v


def _unit(x: Array) -> Array:
    norm = np.linalg.norm(x)
    unit: Array = x / norm if norm > 0.0 else x
    return unit


def _minimise(X: Array, P: Array, G: Array) -> None:
    """Passes of coordinate descent on ½ x G xᵀ − p xᵀ, x ≥ 0, for every row x of X, in place."""
    slope = X @ G - P  # (r, k)
    first = _sweep(X, slope, G)
    for _ in range(_SWEEPS - 1):
        if _sweep(X, slope, G) <= 0.01 * first:
            return


@kernel
def _sweep(X: Array, slope: Array, G: Array) -> float:
    """One pass over X (r, k), updating slope (r, k) = X G − P; returns the squared length of the change.

    A coordinate with G_ll = 0 (a zero column of the other factor) is not changed.
    """
    r, k = X.shape
    moved = 0.0
    for i in range(r):
        for col in range(k):
            if G[col, col] > 0.0:
                step = max(-slope[i, col] / G[col, col], -X[i, col])
                if step != 0.0:
                    X[i, col] += step
                    moved += G[col, col] * step**2
                    for j in range(k):
                        slope[i, j] += step * G[col, j]
    return moved
