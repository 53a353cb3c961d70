"""Linear systems of LAPACK, within kernels."""

from __future__ import annotations

import numpy as np

from tauten.model.numerics.arrays import Array
from tauten.model.numerics.jit import kernel


@kernel
def solve_linear(A: Array, B: Array) -> tuple[bool, Array]:
    """Whether A (n, n) is finite and has an inverse, and A⁻¹ B (n, k), which is zero otherwise."""
    X = np.zeros(B.shape)
    try:
        X = np.ascontiguousarray(np.linalg.solve(A, B))
    except Exception:  # numba knows no other class here
        return False, X
    return True, X
