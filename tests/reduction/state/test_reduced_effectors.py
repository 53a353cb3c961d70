"""Effectors of every kind in reduced coordinates: values, rows and tasks."""

from __future__ import annotations

import numpy as np
import pytest
from support.effectors import SIZE, disturbed, solid
from support.robots.bodies import beam_config, box_mesh
from support.state_bases import basis_of, projected, turned_space

from tauten.controller import Controller, ControllerSettings
from tauten.model import Robot, Simulator, State
from tauten.model.load import build_robot
from tauten.model.schema import PartRobotConfig
from tauten.model.tetra import NodalBody
from tauten.reduction.state import ReducedBody, pod, reduced_robot, reducible


@pytest.fixture(scope="module")
def robot() -> Robot[NodalBody]:
    return solid()


@pytest.fixture(scope="module")
def complete(robot: Robot[NodalBody]) -> Robot[ReducedBody]:
    """All of space as basis, all elements."""
    every = np.arange(robot.body.n_elements)
    return reduced_robot(robot, basis_of(robot, turned_space(robot), every, np.ones(len(every))))


@pytest.fixture(scope="module")
def few(robot: Robot[NodalBody]) -> Robot[ReducedBody]:
    """Six modes of a bent beam, all elements."""
    simulator, states = Simulator(robot, contact="none"), []
    for position in np.linspace(0.0, 0.006, 13)[1:]:
        assert simulator.settle(position=[position]).converged
        states.append(simulator.state.q - robot.rest().q)
    Phi = pod(np.array(states).T, reducible(robot).weight, 6).Phi
    every = np.arange(robot.body.n_elements)
    return reduced_robot(robot, basis_of(robot, Phi, every, np.ones(len(every))))


def test_a_complete_basis_gives_the_same_values_and_rows(
    robot: Robot[NodalBody], complete: Robot[ReducedBody]
) -> None:
    full = disturbed(robot, np.random.default_rng(1), 1e-3)
    alpha = projected(complete, State(full.q, np.zeros(robot.n)))
    expected = robot.rows(full, contacts=False).effectors
    found = complete.rows(alpha, contacts=False).effectors
    np.testing.assert_allclose(found.values, expected.values, atol=1e-12)
    np.testing.assert_allclose(found.positions, expected.positions, atol=1e-12)
    np.testing.assert_allclose(found.delta, expected.delta, atol=1e-12)
    np.testing.assert_allclose(
        found.dense(), expected.dense() @ complete.body.Phi, rtol=1e-9, atol=1e-12
    )
    np.testing.assert_array_equal(complete.effector_values(alpha), found.values)
    assert complete.layout == robot.layout
    assert complete.effector_layout is robot.effector_layout


def test_rows_of_a_few_modes_are_derivatives(few: Robot[ReducedBody]) -> None:
    rng = np.random.default_rng(2)
    layout = few.effector_layout
    alpha = 1e-3 * rng.standard_normal(few.n)
    rows = few.rows(State(alpha, np.zeros(few.n)), contacts=False).effectors
    for _ in range(3):
        step = 1e-6 * rng.standard_normal(few.n)
        after, before = (
            few.effector_values(State(alpha + sign * step, alpha)) for sign in (1.0, -1.0)
        )
        expected = 0.5 * layout.difference(after, before)
        scale = np.maximum(np.abs(expected), 1e-12)
        assert (np.abs(rows.dense() @ step - expected) / scale).max() < 1e-4


def test_a_reduced_robot_reaches_values_of_the_full_one(
    robot: Robot[NodalBody], few: Robot[ReducedBody]
) -> None:
    simulator = Simulator(robot, contact="none")
    assert simulator.settle(position=[0.004]).converged
    goal, layout = simulator.effector_values, robot.effector_layout
    settings = ControllerSettings(qp_solver="daqp", regularisation=1e-6, basis=None, max_pivots=100)
    controller = Controller(few, settings=settings)
    for _ in range(60):
        controller.step(goal)
    assert layout.error(controller.effector_values, goal) < 0.01 * robot.size
    assert controller.position == pytest.approx([0.004], abs=2e-4)


def test_outer_forces_act_on_the_same_places(
    robot: Robot[NodalBody], complete: Robot[ReducedBody]
) -> None:
    force = np.random.default_rng(3).standard_normal(3 * len(robot.effector_names))
    full, reduced = robot.loaded(np.zeros(3), force), complete.loaded(np.zeros(3), force)
    rest = robot.rest()
    expected = complete.body.Phi.T @ full.forces(rest)[0]
    np.testing.assert_allclose(reduced.forces(complete.rest())[0], expected, atol=1e-9)
    assert np.abs(expected).max() > 1e-3


def test_a_part_without_effectors_has_a_reduced_model() -> None:
    """As a gripper has whose robot's only effector is what it holds."""
    settings = PartRobotConfig.model_validate(beam_config(SIZE, effectors=[]))
    robot = build_robot(settings, box_mesh(SIZE, (4, 1, 1)), "part.toml")
    every = np.arange(robot.body.n_elements)
    Phi = np.eye(robot.n)[:, :5] / np.sqrt(reducible(robot).weight[:5])
    reduced = reduced_robot(robot, basis_of(robot, Phi, every, np.ones(len(every))))
    assert len(reduced.effector_values(reduced.rest())) == 0
    assert reduced.body.effector_places.shape == (0, 5)
