"""Steps of a column that would buckle: a rigid plate at its end changes its compliance by little."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.robots.bodies import beam_config
from support.robots.small_bodies import MESH, SIZE, TURN, constrained, moved

from tauten.model import Robot, State, System, row_compliance
from tauten.model.load import build_robot
from tauten.model.numerics import Array
from tauten.model.schema import RobotConfig, validated

LENGTH, WIDTH, HEIGHT = SIZE
STRAIN = 0.009  # Euler's column of these sizes buckles at 0.0082
PLATE = {"lower": [LENGTH, 0.0, 0.0], "upper": [LENGTH, WIDTH, HEIGHT]}
ALL = {"lower": [0.0, 0.0, 0.0], "upper": [LENGTH, WIDTH, HEIGHT]}


def compressed(robot: Robot, free: int) -> State:
    """A state at standstill with a strain along x, of the free nodes and of the plate after them."""
    rest, v = robot.rest(), np.zeros(robot.n)
    along = np.r_[: 3 * free : 3, 3 * free : min(3 * free + 1, robot.n)]
    v[along] = -STRAIN * rest.q[along]
    return State(moved(robot, rest, v).q, np.zeros(robot.n))


def step_of(robot: Robot, state: State) -> tuple[System, Array]:
    """A step of 0.2 s from there, and the compliance (3, 3) of the column's end in it [m/N]."""
    system = robot.linearise(state, None, replace(robot.integration, rate=5.0))
    rows = robot.rows(state, contacts=False).effectors
    return system, row_compliance(system, rows.dense(), rows.delta).W


def test_a_plate_at_the_end_of_a_column_keeps_its_compliance() -> None:
    """With all of the semidefinite tangent the column were four times as stiff."""
    settings = validated(RobotConfig, beam_config(SIZE), "column")
    plain = build_robot(settings, MESH, "column")
    plated = constrained(rigid=[{"name": "plate", "region": PLATE}])
    free = len(plated.body.coordinates.free)
    expected, W_plain = step_of(plain, compressed(plain, plain.n // 3))
    system, W = step_of(plated, compressed(plated, free))
    assert not expected.exact
    assert not system.exact
    assert (system.semidefinite, expected.semidefinite) == (0.25, 0.25)
    assert W[1, 1] == pytest.approx(W_plain[1, 1], rel=0.25)
    assert W[2, 2] == pytest.approx(W_plain[2, 2], rel=0.25)


def test_a_pendulum_that_stands_upright_is_factorised_once_a_step(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What the step before has tried is a matter of time: the same steps follow with and without it."""
    arm = constrained(
        fixed=[],
        gravity=[-9.81, 0.0, 0.0],  # towards the axis
        drives=[{**TURN, "region": ALL, "through": [0.0, 0.0, 0.5 * HEIGHT]}],
    )
    ahead, rest = replace(arm.integration, rate=5.0), arm.rest()
    half = np.zeros(arm.n)
    half[3 * len(arm.body.coordinates.free) + arm.body.frames.drives] = np.pi
    upright, hanging = rest, State(arm.advance(rest, half, 1.0).q, np.zeros(arm.n))
    factors, made = arm.body.factorisation, list[Array]()
    refactor = factors.refactor
    monkeypatch.setattr(factors, "refactor", lambda A: (made.append(A), refactor(A)))
    course = ((upright, 2), (upright, 1), (hanging, 2), (hanging, 1), (upright, 2), (upright, 1))
    for state, tries in course:
        made.clear()
        system, anew = arm.linearise(state, None, ahead), arm.fork().linearise(state, None, ahead)
        assert len(made) == tries
        assert system.exact is anew.exact is (state is hanging)
        np.testing.assert_array_equal(system.v_free, anew.v_free)
        ones = np.ones(arm.n)
        np.testing.assert_array_equal(system.solve(ones), anew.solve(ones))
