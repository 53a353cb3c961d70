import numpy as np
import pytest
import scipy.optimize
from hypothesis import given, settings
from hypothesis import strategies as st

from tauten.model.numerics import coordinates, distances


@settings(deadline=None, max_examples=50)
@given(seed=st.integers(0, 10_000), k=st.integers(1, 12), scale=st.sampled_from([1e-6, 1.0, 1e6]))
def test_kkt_conditions(seed: int, k: int, scale: float) -> None:
    """B ≥ 0, slope Ψᵀ(ΨB − S) ≥ 0, and one of the two zero: the only sign of a nearest point."""
    rng = np.random.default_rng(seed)
    Psi = rng.normal(size=(15, k))
    S = scale * rng.normal(size=(15, 6))
    B = coordinates(Psi, S)
    slope = Psi.T @ (Psi @ B - S)
    size = np.abs(Psi.T @ S).max()
    assert B.min() >= 0.0
    assert slope.min() >= -1e-9 * size
    assert np.abs(slope[1e-9 * B.max(initial=1e-300) < B]).max(initial=0.0) <= 1e-9 * size


def test_agrees_with_scipy(forces: np.ndarray) -> None:
    Psi, S = forces[:, 60:150:6], forces[:, 40::7]
    expected = [scipy.optimize.nnls(Psi, column, maxiter=10_000)[1] for column in S.T]
    np.testing.assert_allclose(distances(Psi, S), expected, atol=1e-6 * np.linalg.norm(S))


def test_points_of_the_cone_are_found() -> None:
    rng = np.random.default_rng(3)
    Psi, B = rng.random((20, 6)), rng.random((6, 9)) * (rng.random((6, 9)) < 0.5)
    np.testing.assert_allclose(coordinates(Psi, Psi @ B), B, atol=1e-9)


def test_equal_generators_do_no_harm() -> None:
    Psi = np.ones((4, 3))
    assert distances(Psi, np.full((4, 1), 2.0)) == pytest.approx(0.0, abs=1e-6)
