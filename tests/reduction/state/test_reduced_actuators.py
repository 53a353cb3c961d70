"""A reduced robot has the actuators of the full one: exact volumes, rows, curvature and couplings."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.robots.bodies import CABLE, pneumatic_robot
from support.state_bases import basis_of

from tauten.controller import Controller
from tauten.model import EmptySpace, Robot, Simulator, State
from tauten.model.tetra import NodalBody
from tauten.reduction.campaign import Design, Run, run_campaign
from tauten.reduction.contact import tip_errors
from tauten.reduction.state import ReducedBody, pod, reduced_robot, reducible
from tauten.reduction.state.held_out import check_errors
from tauten.reduction.state.tetra import integration_points

PUSH = {"name": "push", "point": [0.1, 0.01, 0.01], "direction": [0.0, 3.0, 4.0],
        "max_force": 1.0, "max_travel": 0.1, "max_rate": 1.0}  # fmt: skip
UPPER = {**CABLE, "name": "upper", "points": [[0.01, 0.01, 0.018], [0.1, 0.01, 0.018]]}
DRUM = {"name": "drum", "members": ["tendon", "upper"], "gains": [1.0, -1.0],
        "pretensions": [2.0, 2.0], "max_position": 0.02, "max_effort": 5.0, "max_rate": 0.1}  # fmt: skip


def reduced_of(robot: Robot[NodalBody], modes: int, seed: int = 0) -> Robot[ReducedBody]:
    """Random modes and every element."""
    turn = np.linalg.qr(np.random.default_rng(seed).normal(size=(robot.n, modes)))[0]
    Phi = (
        turn / np.sqrt(3.0 * robot.body.tetrahedra.mass / robot.body.tetrahedra.mass.sum())[:, None]
    )
    every = np.arange(len(integration_points(robot.body.tetrahedra)))
    return reduced_robot(robot, basis_of(robot, Phi, every, np.ones(len(every))))


@pytest.mark.parametrize(
    ("couplings", "element"), [([], "linear"), ([DRUM], "linear"), ([], "quadratic")]
)
def test_rows_and_tangent_are_those_of_the_full_robot_in_the_basis(
    couplings: list[object], element: str
) -> None:
    mesh = {"file": "balloon.vtu", "element": element}
    robot = pneumatic_robot(cables=[CABLE, UPPER], forces=[PUSH], couplings=couplings, mesh=mesh)
    reduced = reduced_of(robot, 12)
    alpha = 2e-3 * np.random.default_rng(1).normal(size=12)
    state = State(alpha, np.zeros(12))
    lifted, Phi = reduced.body.lifted(state), reduced.body.Phi
    rows, full = reduced.rows(state).actuators, robot.rows(lifted).actuators
    assert reduced.n_a == robot.n_a == len(rows)
    np.testing.assert_allclose(rows.delta, full.delta, rtol=1e-9, atol=1e-18)
    np.testing.assert_allclose(rows.H, full.dense() @ Phi, rtol=1e-8, atol=1e-14)
    lam = np.array([1.5, -0.5, 2e3, 0.3])[-robot.n_a :]  # the second cable pushes, as a rod does
    force, K = reduced.forces(state, lam, exact=True)
    full_force, values = robot.forces(lifted, lam, exact=True)
    np.testing.assert_allclose(force, Phi.T @ full_force, rtol=1e-8, atol=1e-12)
    columns = np.stack([product(robot, values, column) for column in Phi.T], axis=1)
    scale = np.abs(K).max()
    np.testing.assert_allclose(K, Phi.T @ columns, rtol=1e-8, atol=1e-9 * scale)


def product(robot: Robot[NodalBody], values: np.ndarray, x: np.ndarray) -> np.ndarray:
    """K x of CSC values."""
    pattern = robot.body.pattern
    column = np.repeat(np.arange(robot.n), np.diff(pattern.indptr))
    return np.bincount(pattern.indices, values * x[column], minlength=robot.n)


def test_without_a_tension_no_chamber_stiffens_the_next_call() -> None:
    reduced = reduced_of(pneumatic_robot(), 8)
    state = State(1e-3 * np.ones(8), np.zeros(8))
    _, before = reduced.forces(state, None, exact=True)
    _, pressed = reduced.forces(state, np.array([3e4]), exact=True)
    _, after = reduced.forces(state, None, exact=True)
    assert np.abs(pressed - before).max() > 0.0
    np.testing.assert_array_equal(before, after)


def test_a_reduced_robot_is_controlled_by_its_pressure() -> None:
    robot = pneumatic_robot()
    simulator = Simulator(robot, "none")
    assert simulator.settle(effort=[2e4]).converged
    goal = simulator.effector
    snapshots = []
    for pressure in np.linspace(-5e3, 4e4, 10):
        assert simulator.settle(effort=[pressure]).converged
        snapshots.append(simulator.state.q - robot.rest().q)
    weight = np.sqrt(3.0 * robot.body.tetrahedra.mass / robot.body.tetrahedra.mass.sum())
    U = np.linalg.svd(weight[:, None] * np.array(snapshots).T, full_matrices=False)[0][:, :4]
    every = np.arange(robot.body.n_elements)
    basis = basis_of(robot, U / weight[:, None], every, np.ones(len(every)))
    follower = Controller(reduced_robot(robot, basis))
    for _ in range(100):
        actuation = follower.step(goal)
    assert actuation.status.usable
    np.testing.assert_allclose(follower.effector, goal, atol=1e-5)
    assert actuation.effort[0] == pytest.approx(2e4, rel=0.02)


def test_errors_of_a_basis_are_those_at_equal_pressure_too(tmp_path: Path) -> None:
    """A model too stiff by 10 %: at equal volume the tip is in place, at equal pressure it stays behind."""
    robot = pneumatic_robot()
    pressures = np.array([[1e3, 2e3, 3e3, 4e3]])
    run = Run(np.full((1, 4), np.nan), np.zeros((3, 4)), np.zeros((3, 4)), pressures)
    found = run_campaign(robot, Design("pressures", (run,)), tmp_path)
    moved = np.linalg.norm(found.effector - robot.effector(robot.rest()).reshape(-1, 1), axis=0)
    Phi = pod(found.q - robot.rest().q[:, None], reducible(robot).weight, 2).Phi
    every = np.arange(robot.body.n_elements)
    states = basis_of(robot, Phi, every, 1.1 * np.ones(len(every)))
    space = EmptySpace(robot.n_c)
    volume = tip_errors(reduced_robot(robot, states), found, space)
    assert volume.error.max() < 1e-3 * moved.max()
    errors = check_errors(robot, states, space, found)
    assert errors.converged.all()
    np.testing.assert_allclose(errors.error, moved * (1.0 - 1.0 / 1.1), rtol=0.05)
