"""State bases: orthonormal in the mass, best of their size, with responses where requested."""

from __future__ import annotations

import numpy as np
import pytest

from tauten.model import EmptySpace, Robot, Simulator, State
from tauten.model.numerics import Array
from tauten.model.tetra import NodalBody
from tauten.reduction.state import enriched, pod, responses


@pytest.fixture(scope="module")
def mass() -> Array:
    """Masses of 20 nodes, three times each, as shares of their sum."""
    masses = np.repeat(np.random.default_rng(0).uniform(0.5, 2.0, 20), 3)
    return 3.0 * masses / masses.sum()


@pytest.fixture(scope="module")
def deviations() -> Array:
    rng = np.random.default_rng(1)
    return rng.normal(size=(60, 30)) * np.geomspace(1.0, 1e-4, 30) @ rng.normal(size=(30, 30))


def gram(Phi: Array, mass: Array) -> Array:
    product: Array = Phi.T @ (mass[:, None] * Phi)
    return product


def test_modes_are_orthonormal_in_the_mass(deviations: Array, mass: Array) -> None:
    Phi = pod(deviations, mass, 8).Phi
    np.testing.assert_allclose(gram(Phi, mass), np.eye(8), atol=1e-12)


def test_coefficients_are_root_mean_square_displacements(mass: Array) -> None:
    shift = np.tile([3e-3, 0.0, 0.0], 20)  # the whole body by 3 mm
    found = pod(shift[:, None], mass, 1)
    assert found.strength == pytest.approx([3e-3])


def test_no_other_modes_leave_out_less(deviations: Array, mass: Array) -> None:
    found = pod(deviations, mass, 5)
    weight = mass[:, None]

    def left_out(Phi: Array) -> float:
        rest = deviations - Phi @ (Phi.T @ (weight * deviations))
        return float(np.sqrt((weight * rest**2).sum() / (weight * deviations**2).sum()))

    assert left_out(found.Phi) == pytest.approx(found.error, rel=1e-6)
    rng = np.random.default_rng(2)
    for _ in range(5):
        other = pod(deviations + 0.1 * rng.normal(size=deviations.shape), mass, 5).Phi
        assert left_out(other) >= found.error


def test_rank_bounds_the_modes(deviations: Array, mass: Array) -> None:
    assert pod(deviations[:, :3], mass, 10).Phi.shape == (60, 3)


def test_enriched_basis_is_orthonormal_and_spans_both(deviations: Array, mass: Array) -> None:
    Phi = pod(deviations, mass, 4).Phi
    vectors = np.random.default_rng(3).normal(size=(60, 3))
    known = Phi @ np.ones((4, 1))  # nothing new
    basis = enriched(Phi, np.hstack([vectors, known]), mass)
    assert basis.shape == (60, 7)
    np.testing.assert_allclose(gram(basis, mass), np.eye(7), atol=1e-12)
    np.testing.assert_allclose(basis[:, :4], Phi)
    fit = np.linalg.lstsq(basis, vectors, rcond=None)[0]
    np.testing.assert_allclose(basis @ fit, vectors, atol=1e-10)


def test_responses_are_where_small_forces_push(thumb: Robot[NodalBody]) -> None:
    """A small tension moves the body along the response to its cable."""
    rest = State(thumb.rest().q, np.zeros(thumb.n))
    found = responses(thumb, EmptySpace(thumb.n_c), rest, np.zeros(1), np.zeros(0, np.int64))
    assert found.shape == (thumb.n, 4)
    light = thumb.loaded(np.zeros(3), np.zeros(3))
    simulator = Simulator(light, contact="none")
    assert simulator.settle(effort=[1e-4], tolerance=1e-10).converged
    moved = simulator.state.q - rest.q
    cosine = moved @ found[:, 3] / np.linalg.norm(moved) / np.linalg.norm(found[:, 3])
    assert cosine > 1.0 - 1e-4
