"""Free vibration about a state of equilibrium."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import LinearOperator, eigsh

from tauten.model.body.sparse_robot import SparseRobot
from tauten.model.numerics import Array, make_factorisation
from tauten.model.robot import State


def natural_frequencies(robot: SparseRobot[Any], state: State, count: int) -> Array:
    """The lowest natural frequencies without damping, cables slack, no contact: (count,) [Hz].

    Solves K x = ω² M x with the exact tangent K at the state and the mass M of what is not fixed, drives
    held, by Lanczos iterations with the inverse of K (scipy's ARPACK).

    Args:
        robot: the robot; its workspace is left alone.
        state: about which it vibrates.
        count: how many; fewer where the robot has few degrees of freedom.

    Raises:
        FactorisationError: K is not positive definite, the body is not held or the state not stable.
    """
    _, values = robot.forces(state, exact=True)
    free = np.setdiff1d(np.arange(robot.n), robot.motor_coordinates)
    whole = robot.matrix(values)
    K = sp.csc_array(whole[:, free][free])
    K.sort_indices()
    M, n = sp.csc_array(robot.mass_matrix(state)[:, free][free]), len(free)
    indptr, indices = K.indptr.astype(np.int64), K.indices.astype(np.int64)
    factors = make_factorisation(indptr, indices, robot.linear_solver)
    factors.refactor(K.data)
    start = np.random.default_rng(0).standard_normal(n)  # the same answer every time
    inverse = LinearOperator((n, n), matvec=lambda b: factors.solve(np.ravel(b)), dtype=float)
    found = eigsh(
        K, k=min(count, n - 1), M=M, sigma=0.0,
        OPinv=inverse, return_eigenvectors=False, v0=start, tol=1e-9,
    )  # fmt: skip
    frequencies: Array = np.sqrt(np.maximum(np.sort(found), 0.0)) / (2.0 * np.pi)
    return frequencies
