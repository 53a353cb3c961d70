"""Reduced robots of beams: the full robot with all strain modes, near it with few."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import csc_array
from support.robots.beam_robots import build, path_of_beams, rectangle
from support.robots.joined import push
from support.robots.short_arm import COUPLING, short_arm
from support.state_bases import basis_of, projected

from tauten.controller import Controller
from tauten.model import Integration, Robot, Simulator, State
from tauten.model.beams import BeamBody
from tauten.model.numerics import Array, FactorisationError
from tauten.reduction.campaign import Ranges, Snapshots, latin_hypercube, run_campaign
from tauten.reduction.contact import ContactBasis, ReduceSettings, make_basis
from tauten.reduction.state import (
    ReducedBody,
    StateBasis,
    StateBasisError,
    StateSettings,
    TipCheck,
    pod,
    reduce_states,
    reduced_robot,
    reducible,
)
from tauten.reduction.state.beams import ReducibleBeams, StrainBody

DYNAMIC = Integration(100.0, False, 0.3, 0.02)


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Robot[BeamBody]:
    return short_arm(tmp_path_factory.mktemp("arm"))


@pytest.fixture(scope="module")
def snapshots(arm: Robot[BeamBody], tmp_path_factory: pytest.TempPathFactory) -> Snapshots:
    design = latin_hypercube(arm, Ranges(tilt=0.0, force=0.0, effort=(0.0, 1.0)), 6, 0, 12)
    found = run_campaign(arm, design, tmp_path_factory.mktemp("arm"))
    return found.select(found.converged)


def with_all_modes(arm: Robot[BeamBody]) -> Robot[StrainBody]:
    """All strains as modes, turned so that no coordinate is one element's; every element carries loads."""
    body = ReducibleBeams(arm)
    n = len(body.weight)
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(n, n)))[0]
    Phi, every = turn / np.sqrt(body.weight)[:, None], np.arange(body.n_elements)
    found = reduced_robot(arm, basis_of(arm, Phi, every, np.ones(len(every))))
    assert isinstance(found.body, StrainBody)
    return found


@pytest.fixture(scope="module")
def complete(arm: Robot[BeamBody]) -> Robot[StrainBody]:
    return with_all_modes(arm)


@pytest.fixture(scope="module")
def basis(arm: Robot[BeamBody], snapshots: Snapshots) -> ContactBasis:
    return make_basis(arm, snapshots, ReduceSettings(k=6))[0]


@pytest.fixture(scope="module")
def states(arm: Robot[BeamBody], snapshots: Snapshots, basis: ContactBasis) -> StateBasis:
    return reduce_states(arm, snapshots, basis, StateSettings(r=14, responses=4))


@pytest.fixture(scope="module")
def reduced(arm: Robot[BeamBody], states: StateBasis) -> Robot[ReducedBody]:
    return reduced_robot(arm, states)


@pytest.fixture
def bent(arm: Robot[BeamBody], snapshots: Snapshots) -> State:
    """The arm bent into contact, with velocities."""
    pushing = (snapshots.lam > 0.0).sum(axis=0)
    q = snapshots.q[:, int(np.argmax(pushing))]
    return State(q, 1e-2 * np.random.default_rng(1).normal(size=arm.n))


def test_displacement_belongs_to_the_state_that_is_given(
    complete: Robot[StrainBody], arm: Robot[BeamBody], bent: State
) -> None:
    """Whatever state was evaluated last; in a bent arm it is what the nodes move by."""
    alpha = projected(complete, bent)
    dq = 1e-6 * np.random.default_rng(6).standard_normal(complete.n)
    before = complete.displacement(alpha, dq)
    straight = complete.displacement(complete.rest(), dq)
    assert complete.displacement(alpha, dq) == before
    assert abs(straight - before) > 0.02 * before
    moved = State(alpha.q + dq, alpha.v)
    x, there = (arm.body.pose(complete.body.lifted(state))[0] for state in (alpha, moved))
    assert np.abs(there - x).max() < 1.01 * before


def motion_of(reduced: Robot[StrainBody], alpha: Array) -> Array:
    """Derivatives (n, r) of the full robot's degrees of freedom by α."""
    J = reduced.body.moved(alpha).motion.J.reshape(-1, 6, reduced.n)
    return J[reduced.body.full.body.dof >= 0].reshape(-1, reduced.n)


def test_strains_determine_the_configuration(
    arm: Robot[BeamBody], complete: Robot[StrainBody], bent: State
) -> None:
    back = complete.body.lifted(projected(complete, bent))
    x, Q = arm.body.pose(back)
    known_x, known_Q = arm.body.pose(bent)
    np.testing.assert_allclose(x, known_x, atol=1e-12)
    np.testing.assert_allclose(np.abs(np.sum(Q * known_Q, axis=1)), 1.0, atol=1e-12)
    np.testing.assert_allclose(back.v, bent.v, atol=1e-9)


def test_strain_energy_is_that_of_the_beams(
    arm: Robot[BeamBody], complete: Robot[StrainBody], bent: State
) -> None:
    light = complete.loaded(np.zeros(3), np.zeros(3))
    state = projected(light, bent)
    assert light.potential(state) == pytest.approx(0.5 * state.q @ state.q, rel=1e-9)
    loaded = complete.loaded(complete.gravity, np.full(3 * len(arm.effector_names), 0.3))
    assert loaded.potential(loaded.rest()) == pytest.approx(0.0, abs=1e-12)


def test_forces_are_those_of_the_full_robot(
    arm: Robot[BeamBody], complete: Robot[StrainBody], bent: State
) -> None:
    outer = np.array([0.3, -0.2, 0.1])
    full, other = arm.loaded(arm.gravity, outer), complete.loaded(arm.gravity, outer)
    state = projected(other, bent)
    force, _ = full.forces(other.body.lifted(state))
    found, _ = other.forces(state)
    expected = motion_of(other, state.q).T @ force
    np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(expected).max())


def test_rows_are_those_of_the_full_robot(
    arm: Robot[BeamBody], complete: Robot[StrainBody], bent: State
) -> None:
    state = projected(complete, bent)
    J, expected, found = motion_of(complete, state.q), arm.rows(bent), complete.rows(state)
    assert len(expected.contacts) > 10
    for known, rows in (
        (expected.effectors, found.effectors),
        (expected.actuators, found.actuators),
        (expected.contacts.rows, found.contacts.rows),
    ):
        np.testing.assert_allclose(rows.delta, known.delta, atol=1e-11)
        np.testing.assert_allclose(rows.dense(), known.H @ J, atol=1e-9)
    np.testing.assert_array_equal(found.contacts.slots, expected.contacts.slots)
    np.testing.assert_allclose(complete.points(state), arm.points(bent), atol=1e-11)
    np.testing.assert_allclose(complete.candidates(state), arm.candidates(bent), atol=1e-11)


def test_rows_are_derivatives(reduced: Robot[ReducedBody], bent: State) -> None:
    state, step = projected(reduced, bent), 1e-6
    direction = np.random.default_rng(2).normal(size=reduced.n)
    ahead = reduced.rows(State(state.q + step * direction, state.v), contacts=False)
    behind = reduced.rows(State(state.q - step * direction, state.v), contacts=False)
    here = reduced.rows(state, contacts=False)
    for far, near, rows in (
        (ahead.effectors, behind.effectors, here.effectors),
        (ahead.actuators, behind.actuators, here.actuators),
    ):
        change = (far.delta - near.delta) / (2.0 * step)
        np.testing.assert_allclose(rows.dense() @ direction, change, atol=1e-8)


@pytest.mark.parametrize("size", [1.0, 6.0])
def test_tangent_is_the_derivative_of_forces_and_cables(
    complete: Robot[StrainBody], size: float
) -> None:
    """With gravity, tension and an outer force, at small and large strains."""
    robot = complete.loaded(np.array([2.0, -3.0, -9.81]), np.array([2.0, -1.0, 3.0]))
    rng, effort = np.random.default_rng(3), np.array([20.0, 5.0, 0.0])
    alpha = size * rng.normal(size=robot.n) / np.sqrt(robot.n)

    def force(at: Array) -> Array:
        state = State(at, at)
        rows = robot.rows(state, contacts=False)
        result: Array = robot.forces(state)[0] + rows.actuators.dense().T @ effort
        return result

    _, K = robot.forces(State(alpha, alpha), effort, exact=True)
    np.testing.assert_allclose(K, K.T, atol=1e-12 * np.abs(K).max())
    for direction in rng.normal(size=(3, robot.n)):
        step = 1e-6 * direction
        expected = (force(alpha - step) - force(alpha + step)) / 2e-6
        np.testing.assert_allclose(K @ direction, expected, atol=1e-6 * np.abs(expected).max())


def test_tangent_in_equilibrium_is_that_of_the_full_robot(
    arm: Robot[BeamBody], complete: Robot[StrainBody]
) -> None:
    """Where all forces are in balance the change of J does no work."""
    simulator, effort = Simulator(arm, "none"), np.array([6.0, 0.0, 0.0])
    assert simulator.settle(effort=effort, tolerance=1e-12).converged
    full = simulator.state
    _, values = arm.forces(full, effort, exact=True)
    pattern = arm.body.pattern
    K = csc_array((values, pattern.indices, pattern.indptr), shape=(arm.n, arm.n))
    state = projected(complete, full)
    J = motion_of(complete, state.q)
    _, found = complete.forces(state, effort, exact=True)
    expected = J.T @ (K @ J)
    np.testing.assert_allclose(found, expected, atol=1e-6 * np.abs(expected).max())


def test_other_tangent_is_positive_definite(complete: Robot[StrainBody]) -> None:
    """Also far beyond buckling, where the exact one is not."""
    pressed = complete.loaded(np.array([0.0, 0.0, 4000.0]), np.zeros(3))
    state = pressed.rest()
    least = [np.linalg.eigvalsh(pressed.forces(state, exact=e)[1])[0] for e in (True, False)]
    assert least[0] < 0.0 < least[1]
    system = pressed.linearise(state)
    assert not system.exact


def test_step_is_that_of_the_full_robot(arm: Robot[BeamBody], complete: Robot[StrainBody]) -> None:
    """From equilibrium, where both have the same tangent."""
    simulator, effort = Simulator(arm, "none"), np.array([6.0, 0.0, 0.0])
    assert simulator.settle(effort=effort, tolerance=1e-12).converged
    v = 1e-2 * np.random.default_rng(4).normal(size=arm.n)
    full = State(simulator.state.q, v)
    known = arm.linearise(full, effort, DYNAMIC)
    state = projected(complete, full)
    found = complete.linearise(state, effort, DYNAMIC)
    J = motion_of(complete, state.q)
    scale = np.abs(known.v_free).max()
    np.testing.assert_allclose(J @ found.v_free, known.v_free, atol=1e-5 * scale)


def test_few_modes_find_the_equilibria(arm: Robot[BeamBody], states: StateBasis) -> None:
    assert states.r == 18
    assert 0 < states.origin.sample < reducible(arm).n_elements / 2
    assert states.origin.tip_mean < 2e-3 * arm.size
    assert states.origin.tip_max < 1e-2 * arm.size


def test_stretch_does_not_lock_bending(arm: Robot[BeamBody], snapshots: Snapshots) -> None:
    """Five modes of strain hold the tip where five modes of position would stretch the spine."""
    body = ReducibleBeams(arm)
    deviations = body.deviations(snapshots.q)
    found = pod(deviations, body.weight, 5)
    shares = body.weight[:, None] * found.Phi**2  # of the energy of each mode
    stretch = shares.reshape(-1, 6, 5)[:, 0].sum(axis=0)
    assert stretch[0] < 0.05


def test_estimate_of_the_error_is_small_on_the_training_path(
    reduced: Robot[ReducedBody], snapshots: Snapshots, basis: ContactBasis
) -> None:
    index = len(snapshots) // 3
    simulator = Simulator(reduced, basis)
    assert simulator.settle(position=snapshots.position[:, index], tolerance=1e-6).converged
    found = TipCheck(reduced, basis)(
        simulator.state, simulator.effort, snapshots.position[:, index]
    )
    assert found < 1e-2 * reduced.size


def test_controller_follows_with_either(arm: Robot[BeamBody], reduced: Robot[ReducedBody]) -> None:
    rest = arm.effector(arm.rest()).ravel()
    goals = [rest + s * np.array([0.015, 0.01, 0.001]) for s in np.linspace(0.0, 1.0, 15)]
    tips = []
    robots: tuple[Robot[BeamBody] | Robot[ReducedBody], ...] = (arm, reduced)
    for robot in robots:
        controller = Controller(robot, "full")
        for goal in goals:
            decision = controller.step(goal)
        assert decision.status.usable
        tips.append(controller.effector.ravel())
    np.testing.assert_allclose(tips[1], tips[0], atol=2e-3 * arm.size)


def test_fork_leaves_the_other_systems_alone(reduced: Robot[ReducedBody]) -> None:
    state = reduced.rest()
    system = reduced.linearise(state)
    before = system.solve(np.ones(reduced.n))
    reduced.fork().linearise(State(np.full(reduced.n, 1e-2), state.v))
    np.testing.assert_array_equal(system.solve(np.ones(reduced.n)), before)


def test_state_that_is_not_finite_is_an_error(reduced: Robot[ReducedBody]) -> None:
    with pytest.raises(FactorisationError, match="positive definite"):
        reduced.linearise(State(np.full(reduced.n, np.nan), np.zeros(reduced.n)))


def test_weights_of_beams_are_one(arm: Robot[BeamBody], states: StateBasis) -> None:
    wrong = basis_of(arm, states.Phi, states.elements, 2.0 * states.weights)
    with pytest.raises(StateBasisError, match="has the weight 2: expected is 1"):
        wrong.check_robot(arm)


def test_closed_loop_of_beams_is_named(tmp_path: Path) -> None:
    nodes = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -0.1], [0.1, 0.0, -0.1], [0.1, 0.0, 0.0]])
    beams = path_of_beams(nodes, (0.0, 1.0, 0.0), "bar")
    material = (1e9, 0.3, 1000.0)
    robot = build(tmp_path, nodes, beams, [rectangle("bar", 0.01, 0.01)], material, [0, 3], 1)
    with pytest.raises(StateBasisError, match=r"beams\.\d from node \d to node \d closes a loop"):
        ReducibleBeams(robot)


def test_beams_given_from_their_outer_end_are_turned_round(tmp_path: Path) -> None:
    nodes = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -0.1], [0.05, 0.02, -0.2]])
    rng, strains = np.random.default_rng(5), []
    moved = np.hstack([nodes[1:] + 0.01 * rng.normal(size=(2, 3)), rng.normal(size=(2, 4))])
    moved[:, 3] = 3.0
    moved[:, 3:] /= np.linalg.norm(moved[:, 3:], axis=1, keepdims=True)
    for ends in ([[0, 1], [1, 2]], [[1, 0], [2, 1]]):
        beams = [{"ends": pair, "profile": "bar", "up": (0.0, 1.0, 0.0)} for pair in ends]
        folder = tmp_path / str(ends[0][0])
        folder.mkdir()
        bars = [rectangle("bar", 0.01, 0.02)]
        robot = build(folder, nodes, beams, bars, (1e9, 0.3, 1000.0), [0], 2)
        body = ReducibleBeams(robot)
        tree, found = body.tree, body.deviations(moved.reshape(-1, 1))[:, 0]
        strains.append(float(found @ (tree.D * found)))
        np.testing.assert_array_equal(tree.beams.ends, [[0, 1], [1, 2]])
    assert strains[0] == pytest.approx(strains[1], rel=1e-12)


def test_coupled_tendons_are_those_of_the_full_robot(tmp_path: Path, bent: State) -> None:
    """Rows of the motors, pretension among the forces, and both of them in the tangent."""
    arm = short_arm(tmp_path, COUPLING)
    robot, lam = with_all_modes(arm), np.array([5.0, 8.0])
    state = projected(robot, bent)
    J = motion_of(robot, state.q)
    known, found = arm.rows(bent).actuators, robot.rows(state).actuators
    assert len(found) == robot.n_a == 2
    np.testing.assert_allclose(found.delta, known.delta, atol=1e-11)
    np.testing.assert_allclose(found.dense(), known.H @ J, atol=1e-9)
    force, _ = arm.forces(bent, lam)
    expected = J.T @ force
    np.testing.assert_allclose(
        robot.forces(state, lam)[0], expected, atol=1e-9 * np.abs(expected).max()
    )

    def total(at: Array) -> Array:
        here = State(at, at)
        rows = robot.rows(here, contacts=False)
        result: Array = robot.forces(here)[0] + rows.actuators.dense().T @ lam
        return result

    direction = np.random.default_rng(6).normal(size=robot.n)
    step = 1e-6 * direction
    change = (total(state.q - step) - total(state.q + step)) / 2e-6
    _, K = robot.forces(state, lam, exact=True)
    np.testing.assert_allclose(K @ direction, change, atol=1e-6 * np.abs(change).max())


def test_forces_are_in_the_reduced_tangent(tmp_path: Path) -> None:
    """Of a force on a lever and of a cable from outside, against finite differences."""
    nodes = np.outer(np.linspace(0.0, 1.0, 4), [0.0, 0.0, 1.0])
    beams = path_of_beams(nodes, (1.0, 0.0, 0.0), "bar")
    cable = {
        "name": "stay", "points": [[0.0, 0.0, 1.0]], "pull_point": [0.4, -0.1, 0.1],
        "max_tension": 100.0, "max_pull": 1.0, "max_rate": 1.0,
    }  # fmt: skip
    arm = build(
        tmp_path, nodes, beams, [rectangle("bar", 0.02, 0.01)], (1e9, 0.3, 1000.0), [0], 3,
        cables=[cable], forces=[push("push", [0.1, 0.2, 1.1], [1.0, 2.0, -3.0], max_outside=1.0)],
    )  # fmt: skip
    robot, lam, rng = with_all_modes(arm), np.array([7.0, -11.0]), np.random.default_rng(4)
    alpha = 0.5 * rng.normal(size=robot.n)
    state = State(alpha, alpha)
    known = arm.rows(robot.body.lifted(state)).actuators
    np.testing.assert_allclose(robot.rows(state).actuators.delta, known.delta, atol=1e-11)

    def total(at: Array) -> Array:
        here = State(at, at)
        result: Array = robot.forces(here)[0] + robot.rows(here).actuators.dense().T @ lam
        return result

    _, K = robot.forces(state, lam, exact=True)
    for direction in rng.normal(size=(3, robot.n)):
        step = 1e-6 * direction
        change = (total(alpha - step) - total(alpha + step)) / 2e-6
        np.testing.assert_allclose(K @ direction, change, atol=1e-6 * np.abs(change).max())
