"""Sampled elements: as many as the tolerance needs, and forces that stay those of an elastic body."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import nnls

from tauten.model import Robot
from tauten.model.numerics import Array, sparse_nnls
from tauten.model.tetra import NodalBody
from tauten.reduction.campaign import Snapshots
from tauten.reduction.state import ElementSample, pod, reducible
from tauten.reduction.state.tetra import contributions, sample_elements


def alphas_of(robot: Robot[NodalBody], Phi: Array, snapshots: Snapshots) -> Array:
    weight = robot.body.tetrahedra.mass / (robot.body.tetrahedra.mass.sum() / 3.0)
    alphas: Array = Phi.T @ (weight[:, None] * (snapshots.q - robot.rest().q[:, None]))
    return alphas


@pytest.fixture(scope="module")
def Phi(thumb: Robot[NodalBody], thumb_ramp: Snapshots) -> Array:
    return pod(thumb_ramp.q - thumb.rest().q[:, None], reducible(thumb).weight, 6).Phi


@pytest.fixture(scope="module")
def sample(thumb: Robot[NodalBody], Phi: Array, thumb_ramp: Snapshots) -> ElementSample:
    return sample_elements(
        thumb.body.tetrahedra, Phi, alphas_of(thumb, Phi, thumb_ramp), tolerance=1e-2
    )


@pytest.mark.parametrize("seed", range(5))
def test_nnls_without_tolerance_is_nnls(seed: int) -> None:
    rng = np.random.default_rng(seed)
    C, d = rng.normal(size=(30, 20)), rng.normal(size=30)
    expected, residual = nnls(C, d)
    w = sparse_nnls(C, d, tolerance=0.0)
    assert (w >= 0.0).all()
    assert np.linalg.norm(C @ w - d) == pytest.approx(residual, rel=1e-9)
    np.testing.assert_allclose(w, expected, atol=1e-8)


def test_nnls_stops_at_its_tolerance_with_fewer_columns() -> None:
    rng = np.random.default_rng(0)
    C = rng.random((100, 300))
    d = C.sum(axis=1)
    counts = []
    for tolerance in (1e-1, 1e-2, 1e-3):
        w = sparse_nnls(C, d, tolerance)
        assert np.linalg.norm(C @ w - d) <= tolerance * np.linalg.norm(d)
        counts.append(int((w > 0.0).sum()))
    assert counts[0] < counts[1] < counts[2] < 100


def test_nnls_takes_columns_of_any_scale_and_leaves_zeros_alone() -> None:
    C = np.diag([1e-3, 1.0, 1e3, 0.0])
    np.testing.assert_allclose(sparse_nnls(C, C.sum(axis=1), 0.0), [1.0, 1.0, 1.0, 0.0])


def test_sample_is_small_and_meets_its_tolerance(
    thumb: Robot[NodalBody], Phi: Array, thumb_ramp: Snapshots, sample: ElementSample
) -> None:
    assert sample.error <= 1e-2
    assert len(sample.elements) < thumb.body.n_elements / 5
    assert (sample.weights > 0.0).all()
    C = contributions(
        thumb.body.tetrahedra, Phi, alphas_of(thumb, Phi, thumb_ramp)[:, ::7], seed=5
    )  # not trained on
    unseen = C[:, sample.elements] @ sample.weights - C.sum(axis=1)
    assert np.linalg.norm(unseen) < 0.05 * np.linalg.norm(C.sum(axis=1))


def test_finer_tolerance_takes_more_elements(
    thumb: Robot[NodalBody], Phi: Array, thumb_ramp: Snapshots, sample: ElementSample
) -> None:
    finer = sample_elements(
        thumb.body.tetrahedra, Phi, alphas_of(thumb, Phi, thumb_ramp), tolerance=1e-3
    )
    assert finer.error <= 1e-3
    assert len(finer.elements) > len(sample.elements)
