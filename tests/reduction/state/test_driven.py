"""Reduced robots with drives, hinges and glue: those of the full robot in the basis, at any angle."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.robots.bodies import CABLE
from support.robots.small_bodies import (
    FIRST,
    GLUE,
    HINGE,
    LAST,
    MESH,
    MIDDLE,
    ROOT,
    RUBBER,
    SECOND,
    SLIDE,
    TOUCH,
    TURN,
    WINCH,
    constrained,
)
from support.state_bases import basis_of, projected

from tauten.controller import Controller
from tauten.model import Robot, State, load_robot
from tauten.model.constraints import ConstrainedBody
from tauten.reduction.state import ReducedBody, StateBasisError, reduced_robot, reducible
from tauten.service.setup import load_setup

MODES = 9


@pytest.fixture(scope="module")
def robot() -> Robot[ConstrainedBody]:
    """Two boxes, glued: a slider, a servo and a hinge, a cable on a preloaded winch, contacts."""
    return constrained(
        [MESH, MESH],
        bodies=[FIRST, SECOND],
        mesh=None, fixed=[], material=RUBBER, gravity=[0.0, 0.0, -9.81],
        attachments=[
            GLUE, HINGE
        ],
        cables=[CABLE],
        drives=[{**SLIDE, "region": LAST}, {**TURN, "region": MIDDLE}],
        couplings=[WINCH],
        **TOUCH,
    )  # fmt: skip


@pytest.fixture(scope="module")
def reduced(robot: Robot[ConstrainedBody]) -> Robot[ReducedBody]:
    """Random modes, every element."""
    body = reducible(robot)
    own, weight = body.own_coordinates, body.weight
    Phi = np.zeros((robot.n, MODES + own))
    random = np.random.default_rng(0).normal(size=(robot.n - own, MODES))
    Phi[: robot.n - own, :MODES] = np.linalg.qr(random)[0] / np.sqrt(weight[:-own, None])
    Phi[robot.n - own :, MODES:] = np.eye(own)
    every = np.arange(body.n_elements)
    return reduced_robot(robot, basis_of(robot, Phi, every, np.ones(len(every))))


@pytest.fixture(scope="module")
def state(reduced: Robot[ReducedBody]) -> State:
    """Drives turned by 40 degrees and more, and moving."""
    rng = np.random.default_rng(1)
    q = np.concatenate([1e-3 * rng.normal(size=MODES), [0.004, 0.7, -0.9]])
    return State(q, np.concatenate([0.02 * rng.normal(size=MODES), [0.1, 3.0, -2.0]]))


def test_forces_tangent_and_rows_are_those_of_the_full_robot(
    robot: Robot[ConstrainedBody], reduced: Robot[ReducedBody], state: State
) -> None:
    lifted, Phi = reduced.body.lifted(state), reduced.body.Phi
    lam = np.array([0.5, 0.2, 1.5])[: robot.n_a]
    for exact in (False, True):
        force, K = reduced.forces(state, lam, exact)
        full_force, values = robot.forces(lifted, lam, exact)
        pattern = robot.body.pattern
        column = np.repeat(np.arange(robot.n), np.diff(pattern.indptr))
        columns = [np.bincount(pattern.indices, values * one[column]) for one in Phi.T]
        np.testing.assert_allclose(force, Phi.T @ full_force, rtol=1e-8, atol=1e-10)
        np.testing.assert_allclose(K, Phi.T @ np.stack(columns, 1), atol=1e-9 * np.abs(K).max())
    found, full = reduced.rows(state), robot.rows(lifted)
    np.testing.assert_allclose(found.actuators.delta, full.actuators.delta, atol=1e-15)
    np.testing.assert_allclose(found.actuators.dense(), full.actuators.dense() @ Phi, atol=1e-12)
    np.testing.assert_allclose(found.effectors.values, full.effectors.values, atol=1e-14)
    np.testing.assert_allclose(found.effectors.dense(), full.effectors.dense() @ Phi, atol=1e-12)
    assert len(full.contacts) > 0
    np.testing.assert_array_equal(found.contacts.slots, full.contacts.slots)
    both = found.contacts.rows.dense(), full.contacts.rows.dense() @ Phi
    np.testing.assert_allclose(*both, atol=1e-12)
    np.testing.assert_allclose(reduced.points(state), robot.points(lifted), atol=1e-14)


@pytest.mark.parametrize("alone", [True, False])
def test_a_step_is_that_of_the_full_robot_in_the_basis(
    robot: Robot[ConstrainedBody], reduced: Robot[ReducedBody], state: State, alone: bool
) -> None:
    """The state is linearised for it alone, or for several."""
    calm = State(0.1 * state.q, state.v)
    system, full = reduced.linearise(calm), robot.linearise(reduced.body.lifted(calm))
    if not alone:
        system = reduced.body.system(reduced.body.assemble(calm), reduced.integration)
    assert system.exact
    assert full.exact
    # A and b of the full system from its solutions; the reduced one has ΦᵀA Φ and Φᵀb
    A, Phi = np.linalg.inv(full.solve(np.eye(robot.n))), reduced.body.Phi
    b = A @ (full.v_free - Phi @ calm.v)
    change = np.linalg.solve(Phi.T @ A @ Phi, Phi.T @ b)
    np.testing.assert_allclose(system.v_free - calm.v, change, atol=1e-6 * np.abs(change).max())


def test_a_step_that_a_drive_holds_up_is_that_of_the_full_robot() -> None:
    """Compressed towards its drive, at a given torque of which it would fall over; with every mode."""
    robot = constrained(
        fixed=[],
        drives=[{**TURN, "region": ROOT, "through": [0.0, 0.0, 0.01]}],
        integration={"rayleigh_stiffness": 0.01},
    )
    body = reducible(robot)
    every = np.arange(body.n_elements)
    Phi = np.diag(1.0 / np.sqrt(body.weight))
    reduced = reduced_robot(robot, basis_of(robot, Phi, every, np.ones(len(every))))
    ahead = replace(robot.integration, rate=5.0)
    q = robot.rest().q.copy()
    q[: robot.n - 1 : 3] *= 0.998
    state = State(q, np.zeros(robot.n))
    full, system = (
        one.linearise(at, None, ahead)
        for one, at in ((robot, state), (reduced, projected(reduced, state)))
    )
    assert not full.exact
    assert not system.exact
    assert system.semidefinite == 0.0
    found = Phi @ system.v_free
    np.testing.assert_allclose(found, full.v_free, atol=1e-8 * np.abs(full.v_free).max())


def test_the_tangent_is_the_derivative_of_the_forces(
    reduced: Robot[ReducedBody], state: State
) -> None:
    direction, step = np.random.default_rng(2).normal(size=reduced.n), 1e-7
    ahead, behind = (
        reduced.forces(State(state.q + sign * step * direction, state.v))[0] for sign in (1.0, -1.0)
    )
    _, K = reduced.forces(state, exact=True)
    difference = -(ahead - behind) / (2.0 * step)
    np.testing.assert_allclose(K @ direction, difference, atol=1e-5 * np.abs(difference).max())


def test_modes_that_move_the_drives_are_refused(robot: Robot[ConstrainedBody]) -> None:
    body = reducible(robot)
    Phi = np.linalg.qr(np.random.default_rng(3).normal(size=(robot.n, 8)))[0]
    Phi /= np.sqrt(body.weight)[:, None]
    every = np.arange(body.n_elements)
    with pytest.raises(
        StateBasisError, match="the last 3 modes of this state basis are not the own coordinates"
    ):
        reduced_robot(robot, basis_of(robot, Phi, every, np.ones(len(every))))


@pytest.mark.long
def test_the_reduced_tripod_takes_the_pose_of_the_full_one() -> None:
    setup, full = load_setup("tripod"), load_robot("tripod")
    assert setup.order == "reduced"
    controllers = [Controller(robot) for robot in (setup.robot, full)]
    goal = controllers[1].effector_values
    goal[2] += 0.004
    for _ in range(40):
        for controller in controllers:
            assert controller.step(goal).status.usable
    one, other = (controller.effector_values for controller in controllers)
    assert np.linalg.norm(one[:3] - other[:3]) < 1e-3 * full.size
    np.testing.assert_allclose(controllers[0].position, controllers[1].position, atol=4e-3)
