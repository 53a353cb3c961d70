"""Dense Cholesky factors: solutions by substitution and by the inverse factor."""

from __future__ import annotations

import numpy as np
import pytest

from tauten.model.numerics import Array, DenseFactors, FactorisationError


def stiff(r: int, condition: float) -> Array:
    """A positive definite matrix (r, r) of this condition number."""
    Q, _ = np.linalg.qr(np.random.default_rng(r).normal(size=(r, r)))
    A: Array = (Q * np.geomspace(1.0, condition, r)) @ Q.T
    return 0.5 * (A + A.T)


@pytest.mark.parametrize("m", [1, 4, 5, 19])
@pytest.mark.parametrize("condition", [1e2, 1e8])
def test_solutions_are_those_of_lapack(m: int, condition: float) -> None:
    """As accurate as the conditioning allows, for a few right-hand sides and for many."""
    A, B = stiff(24, condition), np.random.default_rng(1).normal(size=(24, m))
    factors = DenseFactors(np.zeros_like(A))
    factors.refactor(A)
    found, expected = factors.solve(B), np.linalg.solve(A, B)
    assert np.abs(found - expected).max() < 1e-15 * condition * np.abs(expected).max() + 1e-13
    for column in range(m):
        alone = factors.solve(B[:, column].copy())
        assert (
            np.abs(found[:, column] - alone).max() < 1e-15 * condition * np.abs(alone).max() + 1e-13
        )


def test_indefinite_matrices_are_refused() -> None:
    A = stiff(6, 10.0) - 2.0 * np.eye(6)
    with pytest.raises(FactorisationError):
        DenseFactors(np.zeros_like(A)).refactor(A)
