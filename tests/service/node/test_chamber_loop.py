"""A loop with a cable and a chamber: limits whatever happens, orders to lock, releases."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from support.robots.bodies import CABLE, pneumatic_robot

from tauten.controller import Controller
from tauten.model.tetra import TetRobot
from tauten.service.node import ControlLoop, Signals
from tauten.service.wire import LockOrder, Mode, OperatorCommand, OperatorOrder, RejectionReason


@pytest.fixture(scope="module")
def robot() -> TetRobot:
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
    robot: TetRobot, happens: list[tuple[np.ndarray | None, list[OperatorOrder]]]
) -> None:
    loop, limits = ControlLoop(Controller(robot)), robot.limits
    rest, last = robot.effector(robot.rest()), np.zeros(2)
    for goal, given_orders in happens:
        for order in given_orders:
            loop.obey(order)
        target = None if goal is None else rest + goal
        left = loop.tick(target, Signals(target=target is not None)).actuation
        loop.prepare()
        assert ((limits.pull_min <= left.pull) & (left.pull <= limits.pull_max)).all()
        assert ((limits.tension_min <= left.tension) & (left.tension <= limits.tension_max)).all()
        assert (np.abs(left.pull - last) <= limits.rate * robot.h * (1.0 + 1e-12)).all()
        last = left.pull


def test_a_lock_holds_while_idle_and_while_following(robot: TetRobot) -> None:
    loop = ControlLoop(Controller(robot))
    assert loop.locks.message == "none"
    assert loop.obey(LockOrder("bellows", force=1e4)) is None
    assert loop.locks.message == "bellows at pressure 10000 Pa"
    goal = robot.effector(robot.rest()) + np.array([0.0, 0.0, -0.004])
    for tick in range(60):
        action = loop.tick(goal if tick > 20 else None, Signals(target=tick > 20))
        loop.prepare()
    assert action.mode is Mode.RUN
    assert action.actuation.tension[1] == pytest.approx(1e4)
    assert not action.actuation.clamped
    assert loop.obey(LockOrder("bellows")) is None
    assert loop.locks.values == {}


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
        (OperatorCommand.RESET, RejectionReason.NOT_NOW, "reset is not possible now"),
    ],
)
def test_an_order_that_is_not_possible_is_refused(
    robot: TetRobot, order: OperatorOrder, reason: RejectionReason, text: str
) -> None:
    refused = ControlLoop(Controller(robot)).obey(order)
    assert refused is not None
    assert refused.reason is reason
    assert text in refused.detail


def test_a_stop_releases_what_is_locked_and_a_reset_forgets_it(robot: TetRobot) -> None:
    loop = ControlLoop(Controller(robot))
    loop.obey(LockOrder("tendon", position=0.003))
    loop.obey(LockOrder("bellows", force=1e4))
    for _ in range(20):
        loop.tick(None, Signals(target=False))
        loop.prepare()
    assert loop.controller.pull[0] == pytest.approx(0.003)
    assert loop.controller.tension[1] == pytest.approx(1e4)
    loop.obey(OperatorCommand.STOP)
    refused = loop.obey(LockOrder("tendon", position=0.001))
    assert refused is not None
    assert refused.reason is RejectionReason.NOT_NOW
    while not loop.released:
        loop.tick(None, Signals(target=False))
    np.testing.assert_array_equal(loop.controller.tension, 0.0)
    assert loop.obey(OperatorCommand.RESET) is None
    assert loop.locks.message == "none"
