"""A loop with a cable and a chamber: limits whatever happens, orders to lock, releases."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from support.robots.bodies import CABLE, pneumatic_robot

from tauten.controller import Controller
from tauten.model import Robot
from tauten.model.tetra import NodalBody
from tauten.service.node import Action, ControlLoop, Signals
from tauten.service.wire import (
    Cause,
    LockOrder,
    Mode,
    OperatorCommand,
    OperatorOrder,
    RejectionReason,
)


@pytest.fixture(scope="module")
def robot() -> Robot[NodalBody]:
    return pneumatic_robot(cables=[CABLE])


numbers = st.floats(-0.03, 0.03) | st.floats()
goals = st.none() | st.tuples(numbers, numbers, numbers).map(np.array)
values = st.none() | st.sampled_from([0.0, 1e-6, -1e-6, 0.005, 2e4, -4e3]) | st.floats()
orders = (
    st.sampled_from(list(OperatorCommand))
    | st.just(OperatorCommand.RESET)
    | st.builds(LockOrder, st.sampled_from(["tendon", "bellows", "nobody"]), values, values)
)
events = st.lists(st.tuples(goals, st.lists(orders, max_size=2)), min_size=10, max_size=40)


@settings(
    max_examples=25,
    deadline=None,
    phases=[Phase.explicit, Phase.generate],
    suppress_health_check=[HealthCheck.too_slow],
)
@given(happens=events)
def test_everything_that_leaves_is_within_the_limits(
    robot: Robot[NodalBody], happens: list[tuple[np.ndarray | None, list[OperatorOrder]]]
) -> None:
    loop, limits = ControlLoop(Controller(robot)), robot.limits
    rest, last = robot.effector(robot.rest()), np.zeros(2)
    for goal, given_orders in happens:
        for order in given_orders:
            loop.obey(order)
        target = None if goal is None else rest + goal
        left = loop.tick(target, Signals(target=target is not None)).actuation
        loop.prepare()
        assert (
            (limits.position_min <= left.position) & (left.position <= limits.position_max)
        ).all()
        assert ((limits.effort_min <= left.effort) & (left.effort <= limits.effort_max)).all()
        assert (np.abs(left.position - last) <= limits.rate * robot.h * (1.0 + 1e-12)).all()
        last = left.position


def test_a_lock_waits_while_idle_and_moves_while_following(robot: Robot[NodalBody]) -> None:
    loop = ControlLoop(Controller(robot))
    assert loop.locks.message == "none"
    assert loop.obey(LockOrder("bellows", force=1e4)) is None
    assert loop.locks.message == "bellows at pressure 10000 Pa"
    goal = robot.effector(robot.rest()) + np.array([0.0, 0.0, -0.004])
    for tick in range(60):
        action = loop.tick(goal if tick > 20 else None, Signals(target=tick > 20))
        loop.prepare()
        assert tick > 20 or action.actuation.effort[1] == 0.0
    assert action.mode is Mode.RUN
    assert action.actuation.effort[1] == pytest.approx(1e4)
    assert not action.actuation.clamped
    assert loop.obey(LockOrder("bellows")) is None
    assert loop.locks.values == {}


def tick(loop: ControlLoop, goal: np.ndarray | None, **seen: object) -> Action:
    action = loop.tick(goal, Signals(goal is not None, **seen))  # type: ignore[arg-type]
    loop.prepare()
    return action


def holding(
    robot: Robot[NodalBody], why: str
) -> tuple[ControlLoop, np.ndarray | None, dict[str, object]]:
    """A loop that does not follow, with what it goes on to see: goal and signals."""
    loop = ControlLoop(Controller(robot), enabled=why != "wait")
    near = robot.effector(robot.rest()) + np.array([0.0, 0.0, -0.004])
    for _ in range(8):
        tick(loop, near)
    assert loop.state.mode is (Mode.IDLE if why == "wait" else Mode.RUN)
    if why == "hold":
        assert loop.obey(OperatorCommand.HOLD) is None
    goal = {"unusable": near * np.nan, "no target": None}.get(why, near)
    seen: dict[str, object] = {"in_time": why != "late"}
    if why == "unmeasured":
        seen["measurement"] = Cause.UNMEASURED
    while loop.state.mode is Mode.RUN:
        tick(loop, goal, **seen)
    return loop, goal, seen


LOCKS = (
    (LockOrder("tendon", position=0.008),),
    (LockOrder("tendon", force=1.0),),
    (LockOrder("bellows", force=1e4),),
    (LockOrder("bellows", position=2e-7), LockOrder("tendon", position=0.004)),
)
REASONS = ("hold", "wait", "late", "unmeasured", "unusable", "no target")


@pytest.mark.long
@pytest.mark.parametrize(
    ("why", "locks"),
    [
        # of each reason one with two locks, of each lock one in a hold; the others are slow
        pytest.param(why, locks, marks=[] if why == "hold" or len(locks) > 1 else pytest.mark.slow)
        for why in REASONS
        for locks in LOCKS
    ],
)
def test_no_lock_moves_anything_while_the_node_does_not_follow(
    robot: Robot[NodalBody], why: str, locks: tuple[LockOrder, ...]
) -> None:
    """HOLD does not move: winches keep their position and supplies their effort, whatever is locked."""
    loop, goal, seen = holding(robot, why)
    before = tick(loop, goal, **seen).actuation
    for order in locks:
        assert loop.obey(order) is None
    sealed = locks[0] == LockOrder("bellows", position=2e-7)  # and keeps its volume
    for _ in range(15):
        held = tick(loop, goal, **seen)
        assert held.mode in (Mode.HOLD, Mode.IDLE)
        assert held.actuation.position[0] == before.position[0]
        assert sealed or held.actuation.effort[1] == before.effort[1]
        assert not sealed or held.actuation.position[1] == before.position[1]
    check_locks_are_reached(loop, locks)


def check_locks_are_reached(loop: ControlLoop, locks: tuple[LockOrder, ...]) -> None:
    """Once the node follows, what has been locked moves to its value."""
    robot = loop.controller.robot
    near = robot.effector(robot.rest()) + np.array([0.0, 0.0, -0.004])
    loop.obey(OperatorCommand.ENABLE)
    while loop.state.mode is not Mode.RUN:  # as many ticks in time as were late
        tick(loop, near)
    for _ in range(20):
        moved = tick(loop, near)
    assert moved.mode is Mode.RUN
    for order in locks:
        i = robot.actuators.names.index(order.actuator)
        if order.position is None:
            assert moved.actuation.effort[i] == pytest.approx(order.force)
        else:
            assert moved.actuation.position[i] == pytest.approx(order.position)


def test_an_actuator_on_its_way_to_a_lock_stops_with_the_others(robot: Robot[NodalBody]) -> None:
    loop = ControlLoop(Controller(robot))
    near = robot.effector(robot.rest()) + np.array([0.0, 0.0, -0.004])
    tick(loop, near)
    loop.obey(LockOrder("tendon", position=0.015))
    on_the_way = tick(loop, near).actuation.position[0]
    assert 0.0 < on_the_way < 0.015
    loop.obey(OperatorCommand.HOLD)
    assert all(tick(loop, near).actuation.position[0] == on_the_way for _ in range(20))


@pytest.mark.parametrize(
    ("order", "reason", "text"),
    [
        (
            LockOrder("bellows", force=1e6),
            RejectionReason.LOCK_REFUSED,
            "allowed are -5000 to 40000",
        ),
        (LockOrder("pump", force=0.0), RejectionReason.LOCK_REFUSED, "has no actuator 'pump'"),
        (LockOrder("bellows"), RejectionReason.LOCK_REFUSED, "is not locked"),
        (
            OperatorCommand.RESET,
            RejectionReason.NOT_NOW,
            "reset is not possible now: there was no stop",
        ),
    ],
)
def test_an_order_that_is_not_possible_is_refused(
    robot: Robot[NodalBody], order: OperatorOrder, reason: RejectionReason, text: str
) -> None:
    refused = ControlLoop(Controller(robot)).obey(order)
    assert refused is not None
    assert refused.reason is reason
    assert text in refused.detail


def test_the_reason_for_a_refusal_in_a_stop_is_said(robot: Robot[NodalBody]) -> None:
    """It was only that a reset is not possible now, a moment after a stop."""
    loop = ControlLoop(Controller(robot))
    goal = loop.controller.effector + np.array([0.0, 0.0, 5e-3])
    for _ in range(5):
        tick(loop, goal)
    loop.obey(OperatorCommand.STOP)
    for order, why in (
        (OperatorCommand.RESET, "the actuators are still being released"),
        (OperatorCommand.ENABLE, "it has stopped, reset it first"),
    ):
        refused = loop.obey(order)
        assert refused is not None
        assert refused.detail == f"{order} is not possible now: {why}"


def test_a_stop_releases_what_is_locked_and_a_reset_forgets_it(robot: Robot[NodalBody]) -> None:
    loop = ControlLoop(Controller(robot))
    loop.obey(LockOrder("tendon", position=0.003))
    loop.obey(LockOrder("bellows", force=1e4))
    for _ in range(20):
        tick(loop, robot.effector(robot.rest()))
    assert loop.controller.position[0] == pytest.approx(0.003)
    assert loop.controller.effort[1] == pytest.approx(1e4)
    loop.obey(OperatorCommand.STOP)
    refused = loop.obey(LockOrder("tendon", position=0.001))
    assert refused is not None
    assert refused.reason is RejectionReason.NOT_NOW
    while not loop.released:
        loop.tick(None, Signals(target=False))
    np.testing.assert_array_equal(loop.controller.effort, 0.0)
    assert loop.obey(OperatorCommand.RESET) is None
    assert loop.locks.message == "none"
