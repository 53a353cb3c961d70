"""Results of a controller are copies; a step has one decision; a hold has residuals and a status."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
from support.robots.bodies import beam_robot, box_mesh

from tauten.controller import (
    Actuation,
    Controller,
    Status,
    decide,
    hold_certificate,
    prepare,
)
from tauten.model import Command, Enrichment, Robot, Simulator, forward_step, no_forces
from tauten.model.numerics import Array

SIZE = (0.1, 0.02, 0.02)
DOWN = np.array([0.0, 0.0, -0.01])  # m
EFFECTORS = [
    {"name": "tip", "point": [0.1, 0.01, 0.01]},
    {"name": "middle", "point": [0.05, 0.01, 0.01]},
]


def cable(max_tension: float) -> dict[str, object]:
    """A cable below the middle of the beam, which bends it down."""
    return {
        "name": "lower",
        "points": [[0.01, 0.01, 0.002], [0.1, 0.01, 0.002]],
        "max_tension": max_tension,
        "max_pull": 0.015,
        "max_rate": 0.05,
    }


def bending_beam(max_tension: float = 20.0) -> Robot:
    return beam_robot(
        box_mesh(SIZE, (6, 2, 2)),
        SIZE,
        cables=[cable(max_tension)],
        integration={"scheme": "implicit-euler", "rayleigh_stiffness": 0.02},
        controller={"rate": 50.0},
    )


@pytest.fixture(scope="module")
def beam() -> Robot:
    """A beam with one cable and one effector."""
    return bending_beam()


def spoil(actuation: Actuation) -> None:
    """Overwrite every array of an actuation."""
    for field in fields(actuation):
        value = getattr(actuation, field.name)
        if isinstance(value, np.ndarray):
            value *= 1e3


def test_what_is_returned_can_be_overwritten_without_effect(beam: Robot) -> None:
    controller, other = Controller(beam), Controller(beam)
    goal = controller.effector[0] + DOWN
    for step in range(8):
        first = controller.hold() if step == 4 else controller.decide(goal)
        expected = other.hold() if step == 4 else other.decide(goal)
        np.testing.assert_array_equal(first.position, expected.position)
        spoil(first)
        for array in (controller.position, controller.effort, controller.effector):
            array *= 1e3
        spoil(controller.actuation)
        controller.advance()
        other.advance()
        state, forces = controller.state, controller.forces
        for array in (state.q, state.v, forces.effort, controller.effector):
            array += 1.0
    np.testing.assert_array_equal(controller.effector, other.effector)
    np.testing.assert_array_equal(controller.position, other.position)


def test_states_and_actuations_that_are_passed_in_are_copied(beam: Robot) -> None:
    controller, other = Controller(beam), Controller(beam)
    goal = controller.effector[0] + DOWN
    state, forces, position = controller.state, controller.forces, controller.position
    controller.start_from(state, forces, position)
    for array in (state.q, state.v, forces.effort, position):
        array += 1.0
    for _ in range(3):
        actuation = controller.decide(goal)
        controller.limit(actuation)
        spoil(actuation)
        controller.advance()
        other.step(goal)
    np.testing.assert_array_equal(controller.position, other.position)


def test_a_target_may_be_changed_in_place(beam: Robot) -> None:
    """A decision compares its goal with that of the one before: a caller's array must not be both."""
    controller = Controller(beam, "none")
    target = controller.effector.copy()
    controller.step(target)
    target += DOWN
    decision = controller.last_decision
    assert decision is not None
    assert decision.goal is not None
    np.testing.assert_array_equal(decision.goal, (target - DOWN).ravel())


def test_a_second_decision_replaces_the_first(beam: Robot) -> None:
    controller, other = Controller(beam), Controller(beam)
    goal = controller.effector[0] + 5.0 * DOWN
    limit = beam.limits.rate * beam.h
    for _ in range(4):
        before = controller.position
        for _ in range(3):
            controller.hold()
            actuation = controller.decide(goal)
        assert (np.abs(actuation.position - before) <= limit * (1.0 + 1e-6)).all()
        controller.advance()
        other.step(goal)
        np.testing.assert_array_equal(controller.position, other.position)
    assert controller.position.max() > 0.0


def test_after_a_limit_the_next_decision_starts_from_what_left(beam: Robot) -> None:
    controller = Controller(beam)
    goal, limit = controller.effector[0] + 5.0 * DOWN, beam.limits.rate * beam.h
    for _ in range(5):
        controller.step(goal)
    before = controller.position
    decided = controller.decide(goal)
    assert decided.position[0] > before[0]
    left = decided.with_values(before - 0.5 * limit, decided.effort, clamped=True)
    controller.limit(left)
    np.testing.assert_array_equal(controller.position, left.position)
    controller.advance()
    np.testing.assert_array_equal(controller.position, left.position)
    actuation = controller.decide(goal)
    assert (np.abs(actuation.position - left.position) <= limit * (1.0 + 1e-6)).all()
    np.testing.assert_array_equal(controller.hold().position, left.position)


@pytest.mark.parametrize("target", [10**400, np.zeros((3, 2)), np.zeros(5), np.zeros(3)])
def test_targets_of_other_shapes_are_refused(target: object) -> None:
    robot = beam_robot(box_mesh(SIZE, (6, 2, 2)), SIZE, effectors=EFFECTORS)
    controller = Controller(robot)
    with pytest.raises(ValueError, match=r"expected shape \(2, 3\), the positions of "):
        controller.step(target)  # type: ignore[arg-type]
    np.testing.assert_array_equal(controller.position, 0.0)
    assert controller.step(controller.effector).status is Status.OK
    assert controller.step(controller.effector.ravel()).status is Status.OK


def test_a_hold_above_the_largest_tension_names_the_cable(beam: Robot) -> None:
    """The winches of a weaker cable are wound to where the stronger one pulls with 3 N."""
    simulator = Simulator(beam, contact="none")
    assert simulator.settle(effort=[3.0]).converged
    controller = Controller(bending_beam(max_tension=2.0))
    controller.start_from(simulator.state, simulator.forces, simulator.position)
    actuation = controller.hold()
    assert actuation.needed[0] == pytest.approx(3.0, rel=1e-3)
    assert actuation.effort[0] == 2.0  # what may leave
    assert actuation.status is Status.INFEASIBLE
    assert actuation.conflict == ("tension of cable lower",)
    assert actuation.certificate.primal == pytest.approx(0.5, rel=1e-2)
    np.testing.assert_array_equal(actuation.position, controller.position)


def test_a_hold_has_residuals_of_its_own(beam: Robot) -> None:
    """A force that is wrong by 1 % shows as 1 % of the row values; the right one as rounding."""
    controller = Controller(beam)
    goal = controller.effector[0] + DOWN
    for _ in range(10):
        controller.step(goal)
    actuation = controller.hold()
    assert actuation.status is Status.OK
    assert actuation.effort[0] > 0.1
    robot, state, forces = controller.robot, controller.state, controller.forces
    held = Command.of(controller.position, None)
    none = Enrichment(tolerance=np.inf, rounds=0, per_pair=0)
    prepared = prepare(
        controller.horizon, controller.space, state, forces, controller.position, none
    )
    solved = forward_step(prepared.step, none, forces, held)
    right = hold_certificate(solved, held, robot.limits, robot.actuators)
    wrong = replace(solved, lam=1.01 * solved.lam)
    worse = hold_certificate(wrong, held, robot.limits, robot.actuators)
    for name in ("primal", "complementarity", "stationarity"):
        assert 0.0 <= getattr(right, name) < 1e-9
        assert getattr(actuation.certificate, name) < 1e-9
    assert worse.complementarity == pytest.approx(0.01, rel=0.1)
    assert worse.stationarity == pytest.approx(0.01, rel=0.1)


@pytest.fixture(scope="module")
def closed_tip(finger: Robot) -> Array:
    """Where the finger's tip is with its notches closed."""
    simulator = Simulator(finger, contact="full")
    assert simulator.settle(position=[0.024]).converged
    return simulator.effector[0]


def test_the_same_step_poses_the_same_problem_cold_and_warm(
    finger: Robot, closed_tip: Array
) -> None:
    enrichment = Enrichment(tolerance=5e-5, rounds=5, per_pair=2)
    controller = Controller(finger, "none", enrichment)
    start = controller.effector[0]
    for share in np.linspace(0.0, 1.0, 40):
        controller.step(start + (closed_tip - start) * share)
    robot, forces = controller.robot, controller.forces
    assert len(forces.pushing) > 0
    prepared = prepare(
        controller.horizon,
        controller.space,
        controller.state,
        forces,
        controller.position,
        enrichment,
    )
    cold = replace(prepared, forces=no_forces(robot.n_a, controller.space.k))
    settings = replace(controller.settings, enrichment=replace(enrichment, rounds=0))
    problems = [
        decide(robot, step, closed_tip, controller.position, settings).problem
        for step in (prepared, cold)
    ]
    assert problems[0] is not None
    assert problems[1] is not None
    for first, second in zip(problems[0].arrays, problems[1].arrays, strict=True):
        np.testing.assert_array_equal(first, second)
