"""The loop follows, holds and releases, and never lets anything out of the limits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from support.robots.bodies import CABLE, beam_robot, box_mesh

from tauten.controller import Controller, Status
from tauten.model import Robot, Simulator
from tauten.model.numerics import Array
from tauten.service.node import Action, ControlLoop, Signals
from tauten.service.node.limiter import ActuationLimiter
from tauten.service.settings import ServiceSettings
from tauten.service.wire import Cause, Level, LockOrder, Mode, OperatorCommand

SIZE = (0.1, 0.02, 0.02)
EFFECTORS = [
    {"name": "tip", "point": [0.1, 0.01, 0.01]},
    {"name": "middle", "point": [0.05, 0.01, 0.01]},
]


@pytest.fixture
def loop(beam: Robot) -> ControlLoop:
    return ControlLoop(Controller(beam))


def goal_at(loop: ControlLoop, position: float) -> Array:
    """Where the effectors are when the upper cable is pulled."""
    simulator = Simulator(loop.controller.robot, contact="none")
    assert simulator.settle(position=[0.0, position]).converged
    return simulator.effector


def run(loop: ControlLoop, goal: Array | None, ticks: int, shutdown: bool = False) -> Action:
    for _ in range(ticks):
        action = loop.tick(goal, Signals(goal is not None, shutdown=shutdown))
        loop.prepare()
    return action


def release(loop: ControlLoop) -> list[Action]:
    actions = [run(loop, None, 1, shutdown=True)]
    while not loop.released:
        actions.append(run(loop, None, 1, shutdown=True))
    return actions


def test_it_idles_at_rest_then_follows_then_holds(loop: ControlLoop) -> None:
    idle = run(loop, None, 3)
    assert idle.mode is Mode.IDLE
    assert idle.status is None
    np.testing.assert_array_equal(idle.actuation.position, 0.0)
    goal = goal_at(loop, 0.004)
    following = run(loop, goal, 60)
    assert following.mode is Mode.RUN
    assert following.actuation.position[1] == pytest.approx(0.004, rel=0.02)
    assert np.linalg.norm(following.actuation.effector - goal, axis=1).max() < 2e-4
    held = run(loop, None, 50)
    assert held.mode is Mode.HOLD
    np.testing.assert_array_equal(held.actuation.position, following.actuation.position)
    # a robot whose cables are held does not move
    assert (
        np.linalg.norm(held.actuation.effector - following.actuation.effector, axis=1).max() < 5e-4
    )
    assert run(loop, goal, 1).mode is Mode.RUN


@pytest.mark.long
def test_a_goal_out_of_reach_is_approached_within_the_limits(loop: ControlLoop) -> None:
    limits = loop.controller.robot.limits
    rest = loop.controller.effector
    action = run(loop, rest + np.array([0.0, 0.0, 0.4]), 200)
    assert action.mode is Mode.RUN
    assert action.actuation.effector[0, 2] > rest[0, 2] + 0.02
    assert (action.actuation.position <= limits.position_max).all()
    assert (action.actuation.effort <= limits.effort_max).all()


def test_a_release_ends_slack_after_its_time(loop: ControlLoop) -> None:
    before = run(loop, goal_at(loop, 0.004), 60)
    actions = release(loop)
    h, least = loop.controller.robot.h, ServiceSettings().release_time
    assert len(actions) == max(
        round(least / h), int(np.ceil(before.actuation.position.max() / (0.05 * h)))
    )
    assert {(action.mode, action.cause) for action in actions} == {(Mode.STOP, Cause.SHUTDOWN)}
    np.testing.assert_array_equal(actions[-1].actuation.position, 0.0)
    np.testing.assert_array_equal(actions[-1].actuation.effort, 0.0)
    positions = np.array(
        [before.actuation.position, *(action.actuation.position for action in actions)]
    )
    steps = -np.diff(positions[:, 1])
    np.testing.assert_allclose(
        steps, before.actuation.position[1] / len(actions), rtol=1e-9
    )  # a straight ramp
    assert not any(action.actuation.clamped for action in actions)


def test_after_an_operators_stop_and_reset_it_follows_as_at_first(loop: ControlLoop) -> None:
    goal = goal_at(loop, 0.004)
    first = run(loop, goal, 40)
    assert loop.command(OperatorCommand.STOP)
    stopped = run(loop, goal, 1)
    assert (stopped.mode, stopped.cause) == (Mode.STOP, Cause.OPERATOR)
    assert not loop.command(OperatorCommand.RESET)  # not while cables are pulled
    slack = run(loop, goal, 100)
    np.testing.assert_array_equal(slack.actuation.position, 0.0)
    assert loop.released
    assert not loop.command(OperatorCommand.ENABLE)
    assert loop.command(OperatorCommand.RESET)
    assert run(loop, None, 1).mode is Mode.IDLE
    again = run(loop, goal, 40)
    np.testing.assert_allclose(again.actuation.position, first.actuation.position, atol=1e-6)
    assert loop.command(OperatorCommand.HOLD)
    assert run(loop, goal, 1).mode is Mode.HOLD


# the subscriber refuses positions farther away; the controller refuses NaN and infinity
numbers = st.floats(-1e6, 1e6) | st.floats(-0.2, 0.2) | st.sampled_from([np.nan, np.inf])
goals = st.none() | st.lists(numbers, min_size=6, max_size=6).map(
    lambda values: np.array(values).reshape(2, 3)
)


@pytest.mark.long
@settings(
    max_examples=30, deadline=None, phases=[Phase.explicit, Phase.generate]
)  # each is a run of the whole loop; shrinking would take longer than reading the example
@given(wanted=st.lists(goals, min_size=1, max_size=25))
def test_hostile_goals_move_no_cable_out_of_its_limits(wanted: list[Array | None]) -> None:
    robot = beam_robot(box_mesh(SIZE, (6, 2, 2)), SIZE, effectors=EFFECTORS)
    loop, limits = ControlLoop(Controller(robot)), robot.limits
    position = np.zeros(1)
    actions = [run(loop, goal, 1) for goal in wanted]
    for action in [*actions, *release(loop)]:
        assert np.isfinite([action.actuation.position, action.actuation.effort]).all()
        assert (limits.position_min <= action.actuation.position).all()
        assert (action.actuation.position <= limits.position_max).all()
        assert (limits.effort_min <= action.actuation.effort).all()
        assert (action.actuation.effort <= limits.effort_max).all()
        assert (
            np.abs(action.actuation.position - position) <= limits.rate * robot.h * (1.0 + 1e-12)
        ).all()
        position = action.actuation.position
    np.testing.assert_array_equal(position, 0.0)


def one_cable(max_tension: float, *others: dict[str, object]) -> Robot:
    """A beam whose cable below the middle bears that much [N]."""
    lower = {
        "name": "lower",
        "points": [[0.01, 0.01, 0.002], [0.1, 0.01, 0.002]],
        "max_tension": max_tension,
        "max_pull": 0.015,
        "max_rate": 0.05,
    }
    mesh = box_mesh(SIZE, (6, 2, 2))
    return beam_robot(mesh, SIZE, effectors=EFFECTORS, cables=[lower, *others])


@pytest.mark.parametrize("others", [0, 1])  # cables that are decided meanwhile
def test_health_warns_of_a_lock_that_stops_at_its_largest_tension(others: int) -> None:
    """As far as the cable can be wound with 2 N; where it is locked at less, nothing is said."""
    upper = {**CABLE, "name": "upper", "points": [[0.01, 0.01, 0.018], [0.1, 0.01, 0.018]]}
    loop = ControlLoop(Controller(one_cable(2.0, *[upper] * others)))
    controller, goal = loop.controller, loop.controller.effector
    assert loop.obey(LockOrder("lower", position=0.015)) is None
    run(loop, goal, 30)
    position = float(controller.position[0])
    assert 5e-4 < position < 0.01
    assert controller.effort[0] == pytest.approx(2.0, rel=1e-3)
    assert controller.stalled.tolist() == [True, False][: 1 + others]
    said = f"lower at pull 0.015 m, stopped at {position:g} m by its limits of tension"
    assert (loop.locks.level, loop.locks.message) == (Level.WARN, said)
    assert loop.obey(LockOrder("lower", position=0.5 * position)) is None
    run(loop, goal, 10)
    said = f"lower at pull {0.5 * position:g} m"
    assert (loop.locks.level, loop.locks.message) == (Level.OK, said)
    assert not controller.stalled.any()


def test_a_hold_above_the_largest_tension_reports_both_and_keeps_the_pull() -> None:
    """The winches of a weaker cable are wound to where the stronger one pulls with 3 N."""
    simulator = Simulator(one_cable(20.0), contact="none")
    assert simulator.settle(effort=[3.0]).converged
    weak = Controller(one_cable(2.0))
    weak.start_from(simulator.state, simulator.forces, simulator.position)
    action = run(ControlLoop(weak), None, 1)
    assert action.wanted.status is Status.INFEASIBLE
    assert action.wanted.conflict == ("tension of cable lower",)
    assert action.wanted.needed[0] > 2.5
    assert action.actuation.effort[0] == 2.0
    assert action.actuation.clamped
    assert action.status is None
    np.testing.assert_array_equal(action.actuation.position, simulator.position)


def test_after_a_clamp_the_next_decision_starts_from_what_left(loop: ControlLoop) -> None:
    """The limiter's limits are tighter than the controller's; decisions start from what was published."""
    controller = loop.controller
    limits = controller.robot.limits
    tight = ActuationLimiter(replace(limits, rate=0.25 * limits.rate), controller.robot.h)
    goal, clamped = goal_at(loop, 0.01), 0
    for _ in range(10):
        last = controller.actuation
        wanted = controller.decide(goal)
        left = tight.limit(wanted, last)
        controller.limit(left)
        controller.advance()
        clamped += left.clamped
        np.testing.assert_array_equal(controller.position, left.position)
        # the decision itself is within its own rate of what left, not of what it wanted before
        step = np.abs(wanted.position - last.position)
        assert (step <= limits.rate * controller.robot.h * (1.0 + 1e-6)).all()
    assert clamped > 5
