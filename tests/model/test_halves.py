"""Rows that are solved for by halves are those that are solved for as a whole."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.robots.blocks import block
from support.robots.examples import EXAMPLES

from tauten.model import Robot, Simulator, System, condense_step, load_robot, row_compliance
from tauten.model.numerics import HalfSolving, installed_backends
from tauten.model.step import CondensedStep, EmptySpace, under_friction
from tauten.model.step.compliance import extended

RUBBED = [{"candidates": "below", "against": "floor", "points": "vertices", "friction": 0.5}]

pytestmark = pytest.mark.skipif(
    "pardiso" not in installed_backends(), reason="PARDISO alone solves by halves"
)


def slid() -> tuple[CondensedStep, Simulator]:
    """A step of a block that is pushed over the floor, and what has led there."""
    simulator = Simulator(block(contacts=RUBBED), "full")
    for _ in range(10):
        simulator.step(effort=[0.02])
    given = simulator.robot, EmptySpace(simulator.robot.n_c), simulator.state, simulator.forces
    return condense_step(*given, True, True), simulator


def whole(step: CondensedStep) -> CondensedStep:
    known = step.compliance
    delta = known.delta_free - step.system.h * (known.H @ step.system.v_free)
    return replace(step, compliance=row_compliance(step.system, known.H, delta))


@pytest.mark.parametrize("parts", [False, True])
def test_more_rows_join_those_of_a_system(parts: bool) -> None:
    robot: Robot = load_robot(EXAMPLES / "lift.toml") if parts else block()
    system: System = robot.linearise(robot.rest())
    rng, h = np.random.default_rng(0), system.h
    H, delta, lam = rng.normal(size=(23, robot.n)), rng.normal(size=23), rng.normal(size=23)
    H[:4, : robot.n // 2] = H[8:12, robot.n // 2 :] = 0.0  # rows of one part alone
    found = extended(system, row_compliance(system, H[:20], delta[:20], True), H[20:], delta[20:])
    assert isinstance(found.halves, HalfSolving)
    X = system.solve(np.asfortranarray(H.T)).T
    scale = np.abs(X).max()
    np.testing.assert_allclose(found.X, X, atol=1e-12 * scale)
    W = h * h * (H @ X.T)
    np.testing.assert_allclose(found.W, W, atol=1e-12 * np.abs(W).max())
    np.testing.assert_array_equal(found.W, found.W.T)
    np.testing.assert_allclose(found.delta_free, delta + h * (H @ system.v_free))
    moved = lam @ X
    np.testing.assert_allclose(found.pushed(lam), moved, atol=1e-12 * np.abs(moved).max())


def test_friction_as_a_load_moves_a_block_as_it_does_as_a_whole() -> None:
    step, simulator = slid()
    assert step.frictional
    assert isinstance(step.compliance.halves, HalfSolving)
    assert whole(step).compliance.halves is None
    found, known = (under_friction(one, simulator.forces) for one in (step, whole(step)))
    rubbed = found.system.v_free - step.system.v_free
    assert np.abs(rubbed).max() > 1e-4  # m/s
    np.testing.assert_allclose(
        found.system.v_free, known.system.v_free, atol=1e-12 * np.abs(rubbed).max()
    )
    lam = np.linspace(0.0, 1e-3, len(found.compliance))
    moved, expected = (
        one.system.v_free + one.system.h * one.compliance.pushed(lam) for one in (found, known)
    )
    np.testing.assert_allclose(moved, expected, atol=1e-12 * np.abs(expected).max())


def test_few_rows_and_those_without_friction_are_solved_for_as_a_whole() -> None:
    robot = block()
    system, H = robot.linearise(robot.rest()), np.eye(23, robot.n)
    assert row_compliance(system, H[:5], np.zeros(5), True).halves is None
    assert row_compliance(system, H, np.zeros(23)).halves is None
