"""Free vibration about a state of equilibrium."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from scipy.linalg import eigh
from scipy.sparse.linalg import LinearOperator, eigsh

from tauten.model.body.body import Body
from tauten.model.numerics import Array, FactorisationError, make_factorisation
from tauten.model.state import State
from tauten.model.system import Integration

LIGHT_DAMPING = 0.05  # share of critical damping; decisions keep vibrations swinging that have less

# Of the largest ω² of an unknown alone: below is what nothing holds, by rounding. Of dense matrices all
# eigenvalues have the rounding of the largest one.
ROUNDING, DENSE_ROUNDING = 1e-15, 1e-14


def natural_frequencies(
    body: Body, state: State, count: int, springs: Array | None = None
) -> Array:
    """The lowest natural frequencies without damping, other cables slack, no contact: (count,) [Hz].

    Solves (K + Bᵀ B) x = ω² M x with the exact tangent K at the state and the mass M of what is not fixed,
    drives held.

    Args:
        body: the body; its workspace is left alone.
        state: about which it vibrates.
        count: how many; fewer where the body has few degrees of freedom.
        springs: (s, n) B, of springs that hold it too, see `Robot.spring_rows` [√(N/m)]; None: no others.

    Raises:
        FactorisationError: K is not positive definite, the body is not held or the state not stable.
    """
    K, M = body.matrix(body.forces(state, exact=True)[1]), body.matrix(body.masses(state))
    free = np.setdiff1d(np.arange(body.n), body.motor_coordinates)
    K, M = K[:, free][free], M[:, free][free]
    if springs is not None and len(springs) > 0:
        B = springs[:, free]
        K = K + (B.T @ B if isinstance(K, np.ndarray) else sp.csc_array(B).T @ sp.csc_array(B))
    if isinstance(K, np.ndarray):
        found, rounding = eigh(K, M, eigvals_only=True)[:count], DENSE_ROUNDING
    else:
        found = lowest(sp.csc_array(K), sp.csc_array(M), body.linear_solver, count)
        rounding = ROUNDING
    if not found.min() > rounding * (K.diagonal() / M.diagonal()).max():
        raise FactorisationError("the stiffness is not positive definite")
    frequencies: Array = np.sqrt(np.sort(found)) / (2.0 * np.pi)
    return frequencies


def damping_ratios(scheme: Integration, frequencies: Array) -> Array:
    """Shares of critical damping (k,) that Rayleigh damping of a scheme gives at frequencies (k,) [Hz]."""
    omega = 2.0 * np.pi * frequencies
    shares: Array = 0.5 * (scheme.rayleigh_mass / omega + scheme.rayleigh_stiffness * omega)
    return shares


def lowest(K: sp.csc_array, M: sp.csc_array, solver: str, count: int) -> Array:
    """The lowest eigenvalues (count,) of K x = ω² M x, by Lanczos iterations with K⁻¹ (SciPy's ARPACK).

    Args:
        K: (n, n) stiffness.
        M: (n, n) mass.
        solver: name of the factorisation of K.
        count: how many.

    Raises:
        FactorisationError: K is not positive definite.
    """
    n = K.shape[0]
    K.sort_indices()
    indptr, indices = K.indptr.astype(np.int64), K.indices.astype(np.int64)
    factors = make_factorisation(indptr, indices, solver)
    factors.refactor(K.data)
    start = np.random.default_rng(0).standard_normal(n)  # the same answer every time
    inverse = LinearOperator((n, n), matvec=lambda b: factors.solve(np.ravel(b)), dtype=float)
    found: Array = eigsh(
        K, k=min(count, n - 1), M=M, sigma=0.0,
        OPinv=inverse, return_eigenvectors=False, v0=start, tol=1e-9,
    )  # fmt: skip
    return found
