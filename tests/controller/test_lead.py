"""A target that moves is followed without delay, one that stays or jumps is not led."""

from __future__ import annotations

import numpy as np
import pytest
from support.robots.bodies import pneumatic_robot

from tauten.controller import Controller
from tauten.controller.lead import Lead, leading, no_lead, with_tick
from tauten.model import Simulator
from tauten.model.numerics import Array

TICKS = 10
LAYOUT = pneumatic_robot().effector_layout
STEP = np.array([1e-4, 0.0, -2e-4])  # m, of a target in a tick


def after(goals: list[Array], remaining: Array) -> Lead:
    """The lead after these goals, the last of which left some motion."""
    lead = no_lead()
    for goal in goals:
        lead = with_tick(lead, goal, remaining, TICKS)
    return lead


def test_the_motion_that_a_plan_leaves_is_led_as_far_as_the_target_moves() -> None:
    ramp = [number * STEP for number in range(100)]
    remaining = np.array([3e-4, 1e-3, -1e-2])
    led = leading(after(ramp, remaining), LAYOUT, 100 * STEP, TICKS)
    np.testing.assert_allclose(led, [3e-4, 0.0, -2e-3], atol=1e-7)
    backwards = leading(after(ramp, -remaining), LAYOUT, 100 * STEP, TICKS)
    np.testing.assert_array_equal(backwards, np.zeros(3))


def test_what_alternates_from_tick_to_tick_is_not_led() -> None:
    lead = no_lead()
    for number in range(100):
        lead = with_tick(lead, number * STEP, (-1.0) ** number * np.full(3, 1e-4), TICKS)
    assert np.abs(leading(lead, LAYOUT, 100 * STEP, TICKS)).max() < 1e-5


def test_targets_that_stay_or_jump_or_have_just_come_are_not_led() -> None:
    remaining = np.full(3, 1e-2)
    for goals in ([STEP] * 30, [0.0 * STEP] * 25 + [100 * STEP] * 5, [STEP, 2 * STEP]):
        led = leading(after(goals, remaining), LAYOUT, goals[-1], TICKS)
        np.testing.assert_array_equal(led, np.zeros(3))
    assert not leading(after([STEP] * 30, remaining), LAYOUT, STEP, 1).any()  # one tick


def test_targets_of_half_the_rate_are_led_as_those_of_the_whole() -> None:
    ramp = [2 * (number // 2) * STEP for number in range(30)]
    remaining = np.array([1e-3, 0.0, -2e-3])
    led = leading(after(ramp, remaining), LAYOUT, 30 * STEP, TICKS)
    np.testing.assert_allclose(led, 0.8 * remaining, atol=1e-15)


@pytest.mark.parametrize("stops", [False, True])
def test_a_body_under_pressure_follows_without_the_delay_of_the_horizon(stops: bool) -> None:
    """What moves its tip is the damping's slow answer to the pressure: it was late by half of its way."""
    robot = pneumatic_robot(
        integration={"rayleigh_stiffness": 0.1}, controller={"rate": 50.0}, gravity=[0.0, 0.0, 0.0]
    )
    simulator = Simulator(robot, "none")
    assert simulator.settle(effort=[2e4]).converged
    controller, end = Controller(robot), simulator.effector[0]
    start = controller.effector[0]
    speed = (end - start) / 100  # m in a tick
    for number in range(1, 61):
        goal = start + speed * number
        controller.step(goal)
    late = float((goal - controller.effector[0]) @ speed / (speed @ speed))  # ticks
    assert abs(late) < 0.7
    if not stops:
        return
    farthest = 0.0
    for _ in range(50):
        controller.step(goal)
        beyond = float((controller.effector[0] - goal) @ speed / (speed @ speed))
        farthest = max(farthest, beyond)
    assert farthest < 1.5  # ticks
    assert np.linalg.norm(controller.effector[0] - goal) < 0.3 * np.linalg.norm(speed)
