"""Reduced robots of every element and law: exact with all modes and elements, near the full one with few."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csc_array
from support.robots.bodies import CABLE
from support.robots.small_bodies import KINDS, small_body
from support.state_bases import basis_of, projected, turned_space

from tauten.model import Integration, Robot, Simulator, State
from tauten.model.numerics import Array
from tauten.model.tetra import NodalBody
from tauten.reduction.campaign import Snapshots, ramp, run_campaign
from tauten.reduction.state import ReducedBody, pod, reduced_robot, reducible
from tauten.reduction.state.tetra import integration_points, sample_elements

TENSION = np.array([0.5])


MORE = ("linear, yeoh", "smoothed", "smoothed, neo-hookean", "quadratic")  # others have their parts


@pytest.fixture(
    scope="module",
    params=[
        pytest.param(kind, marks=[pytest.mark.slow] if kind in MORE else [])
        for kind in sorted(KINDS)
    ],
)
def body(request: pytest.FixtureRequest) -> Robot[NodalBody]:
    # a complete basis is dense, and quadratic elements have eight times the nodes of linear ones
    cells = (4, 1, 1) if "quadratic" in request.param else (6, 2, 2)
    return small_body(request.param, cells, cables=[CABLE])


@pytest.fixture(scope="module")
def complete(body: Robot[NodalBody]) -> Robot[ReducedBody]:
    """All of space as basis, all elements with a weight of one."""
    every = np.arange(len(integration_points(body.body.tetrahedra)))
    return reduced_robot(body, basis_of(body, turned_space(body), every, np.ones(len(every))))


@pytest.fixture(scope="module")
def bent(body: Robot[NodalBody]) -> Array:
    """Free degrees of freedom of a body that is bent, twisted and stretched, with some noise."""
    q = body.rest().q.reshape(-1, 3)
    x = q[:, 0]
    noise = 1e-4 * np.random.default_rng(0).normal(size=q.shape)
    moved = np.stack([0.1 * x, 30.0 * x**2 * (q[:, 2] - 0.01), -4.0 * x**2], axis=1)
    result: Array = (q + moved + noise).ravel()
    return result


@pytest.fixture(scope="module")
def snapshots(body: Robot[NodalBody], tmp_path_factory: pytest.TempPathFactory) -> Snapshots:
    folder = tmp_path_factory.mktemp("ramp")
    found = run_campaign(body, ramp(body, step=5e-4), folder)
    return found.select(np.flatnonzero(found.converged))


def test_complete_basis_gives_forces_and_the_exact_tangent(
    body: Robot[NodalBody], complete: Robot[ReducedBody], bent: Array
) -> None:
    Phi, pattern = complete.body.Phi, body.body.pattern
    force, values = body.forces(State(bent, bent), TENSION, exact=True)
    K = csc_array((values, pattern.indices, pattern.indptr), shape=(body.n, body.n))
    alpha = projected(complete, State(bent, bent))
    found, tangent = complete.forces(alpha, TENSION, exact=True)
    np.testing.assert_allclose(found, Phi.T @ force, atol=1e-9 * np.abs(force).max())
    expected = Phi.T @ (K @ Phi)
    np.testing.assert_allclose(tangent, expected, atol=1e-9 * np.abs(expected).max())


def test_other_tangent_is_positive_semidefinite(complete: Robot[ReducedBody], bent: Array) -> None:
    """Also where the body is crushed, and the exact one is not."""
    state = projected(complete, State(0.6 * bent, bent))
    tangents = [complete.forces(state, exact=exact)[1] for exact in (True, False)]
    energies = [np.linalg.eigvalsh(tangent)[0] for tangent in tangents]
    scale = np.abs(tangents[1]).max()
    assert energies[0] < -1e-6 * scale
    assert energies[1] > -1e-10 * scale


def test_few_modes_and_elements_find_the_equilibria(
    body: Robot[NodalBody], snapshots: Snapshots
) -> None:
    deviations = snapshots.q - body.rest().q[:, None]
    Phi = pod(deviations[:, ::2], reducible(body).weight, 8).Phi
    held = body.body.tetrahedra
    alphas = Phi.T @ (held.mass[:, None] / body.body.moving_mass * deviations[:, ::2])
    sample = sample_elements(held, Phi, alphas, tolerance=1e-3)
    points = integration_points(body.body.tetrahedra)
    assert len(sample.elements) < 0.75 * len(points)
    share = sample.weights @ points.volume[sample.elements] / points.volume.sum()
    assert share == pytest.approx(1.0, abs=0.1)
    reduced = reduced_robot(body, basis_of(body, Phi, sample.elements, sample.weights))
    check_tangent(reduced, alphas[:, -1].copy())
    simulator = Simulator(reduced, contact="none")
    travelled = np.ptp(snapshots.effector, axis=1).max()
    for i in range(1, len(snapshots), 6):  # at states that took no part in the training
        report = simulator.settle(position=snapshots.position[:, i], tolerance=1e-7)
        assert report.converged
        apart = np.linalg.norm(simulator.effector.ravel() - snapshots.effector[:, i])
        assert apart < 2e-3 * travelled


def check_tangent(reduced: Robot[ReducedBody], alpha: Array) -> None:
    """The tangent of the sample is the derivative of its force."""
    _, K = reduced.forces(State(alpha, alpha), exact=True)
    np.testing.assert_allclose(K, K.T, atol=1e-9 * np.abs(K).max())
    direction = np.random.default_rng(3).normal(size=reduced.n)
    step = 1e-7 * direction
    forth, _ = reduced.forces(State(alpha + step, alpha))
    back, _ = reduced.forces(State(alpha - step, alpha))
    expected = (back - forth) / 2e-7
    np.testing.assert_allclose(K @ direction, expected, atol=1e-5 * np.abs(expected).max())


def test_step_is_that_of_the_full_body(
    body: Robot[NodalBody], complete: Robot[ReducedBody], bent: Array
) -> None:
    v = 0.01 * bent
    full = State(bent, v)
    scheme = Integration(100.0, False, 0.3, 0.02)
    known = body.linearise(full, TENSION, scheme)
    found = complete.linearise(projected(complete, full), TENSION, scheme)
    scale = np.abs(known.v_free).max()
    np.testing.assert_allclose(complete.body.Phi @ found.v_free, known.v_free, atol=1e-7 * scale)
