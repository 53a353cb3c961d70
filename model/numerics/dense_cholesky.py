"""Cholesky factors of small dense matrices in compiled loops, without the set-up of LAPACK calls."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.numerics.arrays import Array
from tauten.model.numerics.factorisation import FactorisationError
from tauten.model.numerics.jit import kernel

FEW = 4  # right-hand sides for which substitution is as fast as a product with the inverse factor


@kernel
def cholesky(A: Array, L: Array) -> bool:
    """Write the lower factor of A to L; False when A is not positive definite or not finite."""
    for i in range(A.shape[0]):
        for j in range(i + 1):
            value = A[i, j]
            for k in range(j):
                value -= L[i, k] * L[j, k]
            if j < i:
                L[i, j] = value / L[j, j]
            elif value > 0.0 and value < np.inf:
                L[i, i] = np.sqrt(value)
            else:
                return False
    return True


@kernel
def solve_in_place(L: Array, b: Array) -> None:
    """Overwrite b (r,) with (L Lᵀ)⁻¹ b."""
    r = b.shape[0]
    for i in range(r):
        value = b[i]
        for j in range(i):
            value -= L[i, j] * b[j]
        b[i] = value / L[i, i]
    for i in range(r - 1, -1, -1):
        b[i] /= L[i, i]
        for j in range(i):
            b[j] -= L[i, j] * b[i]


@kernel
def solve_rows(L: Array, rows: Array) -> Array:
    """Rows (m, r) of the solutions to rows of right-hand sides (m, r), by substitution."""
    X = rows.copy()
    for i in range(X.shape[0]):
        solve_in_place(L, X[i])
    return X


@kernel
def _solve_many_rows(L: Array, rows: Array, X: Array) -> None:
    """`solve_rows` into X (m, r) by products with L⁻¹: the short loops of substitution depend on each other.

    Not for matrices that are nearly singular.
    """
    inverse = np.zeros_like(L)
    for i in range(L.shape[0]):
        scale = 1.0 / L[i, i]
        inverse[i, i] = scale
        for k in range(i):
            factor = scale * L[i, k]
            for j in range(k + 1):
                inverse[i, j] -= factor * inverse[k, j]
    X[:] = np.dot(np.dot(rows, inverse.T), inverse)


@dataclass(frozen=True, slots=True, eq=False)
class DenseFactors:
    """Cholesky factors of the small dense A; a `tauten.model.numerics.factorisation.Factorisation`.

    Attributes:
        L: (r, r) lower factor, overwritten with every system.
    """

    L: Array
    name = "dense"

    def fork(self) -> DenseFactors:
        """Memory of its own for factors of the same size."""
        return DenseFactors(np.empty_like(self.L))

    def refactor(self, values: Array) -> None:
        """Factorise the matrix (r, r)."""
        if not cholesky(values, self.L):
            raise FactorisationError("not positive definite")

    def solve(self, B: Array) -> Array:
        """A⁻¹ B for B (r,) or (r, m)."""
        if B.ndim == 1:
            x = B.copy()
            solve_in_place(self.L, x)
            return x
        rows = np.ascontiguousarray(B.T)
        if B.shape[1] <= FEW:
            return solve_rows(self.L, rows).T
        X = np.empty(rows.shape)
        _solve_many_rows(self.L, rows, X)
        return X.T
