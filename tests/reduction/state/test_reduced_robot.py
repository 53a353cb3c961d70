"""The reduced robot is the full one where its basis is complete, and near it where it is not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import csc_array
from support.state_bases import basis_of, projected, turned_space

from tauten.controller import Controller
from tauten.model import Integration, Robot, Simulator, State
from tauten.model.numerics import Array, FactorisationError
from tauten.model.points import segment_nodes
from tauten.model.points.paths import SHORTEST
from tauten.model.tetra import NodalBody
from tauten.reduction.campaign import Snapshots
from tauten.reduction.state import ReducedBody, StateBasisError, pod, reduced_robot, reducible
from tauten.reduction.state.tetra import sample_elements

DYNAMIC = Integration(100.0, False, 0.3, 0.02)
STATIC = Integration(50.0, True)


@pytest.fixture(scope="module")
def complete(thumb: Robot[NodalBody]) -> Robot[ReducedBody]:
    """All of space as basis, turned so that no coordinate is a node's; all elements."""
    every = np.arange(thumb.body.n_elements)
    return reduced_robot(thumb, basis_of(thumb, turned_space(thumb), every, np.ones(len(every))))


@pytest.fixture(scope="module")
def reduced(thumb: Robot[NodalBody], thumb_ramp: Snapshots) -> Robot[ReducedBody]:
    """Twelve modes and a sample of the elements."""
    deviations = thumb_ramp.q - thumb.rest().q[:, None]
    Phi = pod(deviations, reducible(thumb).weight, 12).Phi
    held = thumb.body.tetrahedra
    alphas = Phi.T @ (held.mass[:, None] / thumb.body.moving_mass * deviations)
    sample = sample_elements(held, Phi, alphas, tolerance=1e-3)
    return reduced_robot(thumb, basis_of(thumb, Phi, sample.elements, sample.weights))


@pytest.fixture(scope="module")
def bent(
    thumb: Robot[NodalBody], thumb_ramp: Snapshots, complete: Robot[ReducedBody]
) -> tuple[State, State]:
    """A bent and moving thumb with its notches in contact, and the same in the complete basis."""
    v = 1e-2 * np.random.default_rng(1).normal(size=thumb.n)
    full = State(thumb_ramp.q[:, -1], v)
    return full, projected(complete, full)


@pytest.mark.parametrize("exact", [True, False])
def test_complete_basis_gives_forces_and_tangent(
    thumb: Robot[NodalBody], complete: Robot[ReducedBody], bent: tuple[State, State], exact: bool
) -> None:
    full, alpha = bent
    Phi, effort = complete.body.Phi, np.array([2.0])
    force, values = thumb.forces(full, effort, exact)
    K = matrix(thumb, values)
    found, tangent = complete.forces(alpha, effort, exact)
    np.testing.assert_allclose(found, Phi.T @ force, atol=1e-9 * np.abs(force).max())
    expected = Phi.T @ (K @ Phi)
    np.testing.assert_allclose(tangent, expected, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize("longer", [None, 1.0, 10.0])
@pytest.mark.parametrize("scheme", [DYNAMIC, STATIC])
def test_complete_basis_gives_the_step(
    thumb: Robot[NodalBody],
    complete: Robot[ReducedBody],
    bent: tuple[State, State],
    scheme: Integration,
    longer: float | None,
) -> None:
    """The state is linearised for it alone, or for it and one that is longer."""
    full, alpha = bent
    Phi, effort = complete.body.Phi, np.array([2.0])
    if longer is None:
        found = complete.linearise(alpha, effort, scheme)
    else:
        assembled = complete.body.assemble(alpha, effort, scheme)
        scheme = replace(scheme, rate=scheme.rate / longer)
        found = complete.body.system(assembled, scheme)
    known = thumb.linearise(full, effort, scheme)
    scale = np.abs(known.v_free).max()
    np.testing.assert_allclose(Phi @ found.v_free, known.v_free, atol=1e-7 * scale)
    np.testing.assert_allclose(Phi @ found.v, known.v, atol=1e-12)
    B = np.random.default_rng(2).normal(size=(thumb.n, 3))
    X = known.solve(B)
    np.testing.assert_allclose(Phi @ found.solve(Phi.T @ B), X, atol=1e-7 * np.abs(X).max())
    moved = complete.advance(alpha, found.v_free, found.h)
    expected = thumb.advance(full, known.v_free, known.h)
    np.testing.assert_allclose(complete.body.lifted(moved).q, expected.q, atol=1e-9)


def test_complete_basis_gives_the_rows(
    thumb: Robot[NodalBody], complete: Robot[ReducedBody], bent: tuple[State, State]
) -> None:
    full, alpha = bent
    Phi, expected, found = complete.body.Phi, thumb.rows(full), complete.rows(alpha)
    assert len(expected.contacts) > 5
    for known, rows in (
        (expected.effectors, found.effectors),
        (expected.actuators, found.actuators),
        (expected.contacts.rows, found.contacts.rows),
    ):
        np.testing.assert_allclose(rows.delta, known.delta, atol=1e-12)
        np.testing.assert_allclose(rows.dense(), known.H @ Phi, atol=1e-10)
    np.testing.assert_array_equal(found.contacts.slots, expected.contacts.slots)
    np.testing.assert_array_equal(found.contacts.pair, expected.contacts.pair)
    np.testing.assert_allclose(complete.points(alpha), thumb.points(full), atol=1e-12)
    np.testing.assert_allclose(complete.candidates(alpha), thumb.candidates(full), atol=1e-12)


def test_a_system_says_whether_its_tangent_is_the_exact_one(
    thumb: Robot[NodalBody], complete: Robot[ReducedBody]
) -> None:
    """As that of the full robot does; compressed to 60 % of its length, the exact one is indefinite."""
    rest = thumb.rest()
    squeezed = rest.q.reshape(-1, 3).copy()
    long = int(np.ptp(squeezed, axis=0).argmax())
    squeezed[:, long] *= 0.6
    for full, exact in ((rest, True), (State(squeezed.ravel(), np.zeros(thumb.n)), False)):
        assert thumb.linearise(full, integration=STATIC).exact is exact
        system = complete.linearise(projected(complete, full), integration=STATIC)
        assert system.exact is exact
        assert system.tangent is not None
        _, K = complete.forces(projected(complete, full), exact=exact)
        np.testing.assert_allclose(system.tangent, K, atol=1e-9 * np.abs(K).max())


@pytest.mark.parametrize("apart", [0.3, 0.0])
def test_short_segments_of_cables_are_rounded_as_in_the_full_robot(
    thumb: Robot[NodalBody], complete: Robot[ReducedBody], apart: float
) -> None:
    """Two stations of a cable at a distance of 0.3 of that from which lengths are rounded, and at none."""
    actuators, dof = thumb.actuator_set, thumb.body.pattern.dof
    x, effort = thumb.body.mesh.nodes, np.array([2.0])
    ends = actuators.paths.segments(actuators.stations.at(x))[0]  # (2, 3)
    across = ends[1] - ends[0]
    along = across / np.linalg.norm(across)
    second = segment_nodes(actuators.paths, actuators.stations)[0, 4:]
    second = second[dof[second] >= 0]
    q = thumb.rest().q.copy()
    q[dof[second][:, None] + np.arange(3)] += apart * SHORTEST * along - across
    full = State(q, np.zeros(thumb.n))
    short = projected(complete, full)
    near = np.linalg.norm(np.diff(thumb.actuator_segments(full)[0], axis=0))
    assert near == pytest.approx(apart * SHORTEST, abs=1e-12)
    ours, theirs = (item.actuators for item in (complete.rows(short), thumb.rows(full)))
    np.testing.assert_allclose(ours.delta, theirs.delta, atol=1e-9)
    np.testing.assert_allclose(ours.dense(), theirs.dense() @ complete.body.Phi, atol=1e-6)
    _, with_tension = complete.forces(short, effort)
    _, without = complete.forces(short)
    taut, slack = (
        complete.body.Phi.T @ (matrix(thumb, thumb.forces(full, lam)[1]) @ complete.body.Phi)
        for lam in (effort, None)
    )
    expected = taut - slack
    np.testing.assert_allclose(with_tension - without, expected, atol=1e-6 * np.abs(expected).max())


def matrix(robot: Robot[NodalBody], values: Array) -> csc_array:
    pattern = robot.body.pattern
    return csc_array((values, pattern.indices, pattern.indptr), shape=(robot.n, robot.n))


def test_tangent_of_a_sample_is_the_derivative_of_its_force(reduced: Robot[ReducedBody]) -> None:
    rng = np.random.default_rng(3)
    alpha = 2e-3 * rng.normal(size=reduced.n)
    _, K = reduced.forces(State(alpha, alpha), exact=True)
    np.testing.assert_allclose(K, K.T, atol=1e-9 * np.abs(K).max())
    for direction in rng.normal(size=(3, reduced.n)):
        step = 1e-7 * direction
        forth, _ = reduced.forces(State(alpha + step, alpha))
        back, _ = reduced.forces(State(alpha - step, alpha))
        expected = (back - forth) / 2e-7
        np.testing.assert_allclose(K @ direction, expected, atol=1e-6 * np.abs(expected).max())


def test_sample_has_an_energy(reduced: Robot[ReducedBody]) -> None:
    """Work round a closed loop vanishes."""
    loop = 1e-3 * np.random.default_rng(4).normal(size=(2, reduced.n))
    angles = np.linspace(0.0, 2.0 * np.pi, 200, endpoint=False)  # trapezia: exact for a smooth loop
    work, size = 0.0, 0.0
    for angle in angles:
        alpha = np.cos(angle) * loop[0] + np.sin(angle) * loop[1]
        tangent = -np.sin(angle) * loop[0] + np.cos(angle) * loop[1]
        force, _ = reduced.forces(State(alpha, alpha))
        work, size = work + force @ tangent, size + abs(force @ tangent)
    assert size > 0.0
    assert abs(work) < 1e-9 * size


def test_equilibria_are_those_of_the_full_thumb(
    thumb_ramp: Snapshots, reduced: Robot[ReducedBody]
) -> None:
    simulator = Simulator(reduced, contact="full")
    apart = []
    for i in range(0, len(thumb_ramp), 4):
        report = simulator.settle(position=thumb_ramp.position[:, i], tolerance=1e-6)
        assert report.converged
        assert report.deepest_gap > -1e-6
        apart.append(np.linalg.norm(simulator.effector.ravel() - thumb_ramp.effector[:, i]))
    assert max(apart) < 1e-4  # of 50 mm


def test_controller_decides_the_same_with_either(
    thumb: Robot[NodalBody], reduced: Robot[ReducedBody]
) -> None:
    """The same targets ask the same pulls of the cable."""
    goals = [
        np.array([0.0075 + 0.006 * s, 0.0075, -0.05 + 0.001 * s]) for s in np.linspace(0, 1, 25)
    ]
    positions = []
    robots: tuple[Robot, ...] = (thumb, reduced)
    for robot in robots:
        controller = Controller(robot, "full")
        positions.append([float(controller.step(goal).position[0]) for goal in goals])
    assert max(positions[0]) > 2e-3
    np.testing.assert_allclose(positions[1], positions[0], atol=5e-5)


def test_fork_leaves_the_other_systems_alone(reduced: Robot[ReducedBody]) -> None:
    state = reduced.rest()
    system = reduced.linearise(state)
    before = system.solve(np.ones(reduced.n))
    reduced.fork().linearise(State(np.full(reduced.n, 1e-3), state.v))
    np.testing.assert_array_equal(system.solve(np.ones(reduced.n)), before)


def test_gravity_and_outer_forces_are_those_of_the_full_robot(
    thumb: Robot[NodalBody], complete: Robot[ReducedBody]
) -> None:
    gravity, position = np.array([1.0, -2.0, 3.0]), np.array([0.1, 0.0, 0.2])
    expected = complete.body.Phi.T @ thumb.loaded(gravity, position).body.tetrahedra.load
    np.testing.assert_allclose(complete.loaded(gravity, position).body.load, expected)


def test_projection_undoes_lifting(reduced: Robot[ReducedBody]) -> None:
    rng = np.random.default_rng(5)
    state = State(1e-3 * rng.normal(size=reduced.n), rng.normal(size=reduced.n))
    back = projected(reduced, reduced.body.lifted(state))
    np.testing.assert_allclose(back.q, state.q, atol=1e-12)
    np.testing.assert_allclose(back.v, state.v, atol=1e-10)


def test_state_that_is_not_finite_is_an_error(reduced: Robot[ReducedBody]) -> None:
    with pytest.raises(FactorisationError, match="positive definite"):
        reduced.linearise(State(np.full(reduced.n, np.nan), np.zeros(reduced.n)))


def test_basis_of_another_robot_is_refused(
    finger: Robot[NodalBody], thumb: Robot[NodalBody], reduced: Robot[ReducedBody]
) -> None:
    with pytest.raises(StateBasisError, match="made for robot 'thumb'"):
        reduced_robot(finger, basis_of(thumb, reduced.body.Phi, np.array([0]), np.ones(1)))


def test_earlier_detection_does_not_change_the_result(
    thumb_ramp: Snapshots, reduced: Robot[ReducedBody]
) -> None:
    robot = reduced.fork()
    for i in range(0, len(thumb_ramp), 5):
        full = State(thumb_ramp.q[:, i], np.zeros(len(thumb_ramp.q)))
        state = projected(robot, full)
        known, fresh = robot.rows(state).contacts, reduced.fork().rows(state).contacts
        np.testing.assert_array_equal(known.slots, fresh.slots)
        np.testing.assert_array_equal(known.rows.delta, fresh.rows.delta)
        np.testing.assert_array_equal(known.rows.H, fresh.rows.H)
    assert len(known) > 5
