"""A grasp that is let go: what an operator is told, and that it is state of the controller."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.robots.bodies import pressed, pressing_finger

from tauten.controller import Controller
from tauten.model.numerics import Array
from tauten.service.link.commanding import answer_in
from tauten.service.node import Action, ControlLoop, Signals
from tauten.service.node.metrics import prometheus_text
from tauten.service.node.outputs import contact_diagnostic
from tauten.service.replay import actions
from tauten.service.replay.replaying import RecordedTick
from tauten.service.wire import JSON, Diagnostic, Joints, Level, Mode, OperatorCommand, Tick
from tauten.service.wire.commands import decode_command


def test_an_operator_lets_go_and_is_told_of_what(caplog: pytest.LogCaptureFixture) -> None:
    controller = Controller(pressing_finger(0.0, min_force=0.08))
    loop, order = ControlLoop(controller), decode_command(b'{"data": "let-go"}', JSON)
    assert order is OperatorCommand.LET_GO
    with caplog.at_level("INFO"):
        assert loop.obey(order) is None
        assert let_go_in(controller) == ""
        pressed(controller, 0.02, 15)
        assert contact_diagnostic(controller).values["kept"] == "below on table"
        assert loop.obey(order) is None
    assert [one.message for one in caplog.records] == [
        "let go: nothing was grasped", "let go: below on table",
    ]  # fmt: skip
    assert contact_diagnostic(controller).values["kept"] == "none"
    assert pressed(controller, -0.02, 5)[0] == 0.0
    assert let_go_in(controller) == "below on table"  # what `tauten command finger let-go` says
    controller.reset()
    assert let_go_in(controller) == ""


def let_go_in(controller: Controller) -> str:
    """What an operator reads in the metrics of a node with this controller."""
    decisions = Diagnostic("decisions", Level.OK, "", {"mode": Mode.RUN.value, "cause": ""})
    commands = Diagnostic("commands", Level.OK, "", {"accepted": "1", "refused": "0"})
    found = [contact_diagnostic(controller), decisions, commands]
    return answer_in(prometheus_text("finger", found, {}).decode()).let_go


@pytest.mark.parametrize("order", [None, OperatorCommand.LET_GO])
def test_a_grasp_is_taken_over(order: OperatorCommand | None) -> None:
    """By a model that replaces another one, as it is: kept, or let go."""
    robot = pressing_finger(0.0, min_force=0.08)
    first, second = Controller(robot), Controller(robot)
    pressed(first, 0.02, 15)
    if order is not None:
        assert first.let_go() == ("below on table",)
    second.take_over(first, first.state)
    assert second.grasp == first.grasp
    force, _, _ = pressed(second, -0.02, 5)
    assert force == (pytest.approx(0.08, rel=0.1) if order is None else 0.0)


def test_a_replay_lets_go_as_the_run_did() -> None:
    """The order is in the log, and nothing else of the grasp."""
    robot = pressing_finger(0.0, min_force=0.08)
    run, again = ControlLoop(Controller(robot)), ControlLoop(Controller(robot))
    rest, recorded, wanted = run.controller.effector_values, list[RecordedTick](), list[Action]()
    for tick in range(30):
        orders = (OperatorCommand.LET_GO,) if tick == 22 else ()
        for order in orders:
            assert run.obey(order) is None
        goal = rest + np.array([0.0, 0.0, -0.02 if tick < 15 else 0.02])
        action = run.tick(goal, Signals(target=True))
        run.prepare()
        wanted.append(action)
        recorded.append(recorded_tick(tick, action, goal, orders))
    found = [action for _, _, action in actions(iter(recorded), again)]
    assert [one.actuation.position.tolist() for one in found] == [
        one.actuation.position.tolist() for one in wanted
    ]
    one, other = again.controller.grasp, run.controller.grasp
    assert one is not None and other is not None
    assert (one.kept, one.let_go, one.released) == (other.kept, other.let_go, other.released)
    assert again.controller.contacts.normal_force.sum() == 0.0
    unheard = [replace(one, orders=()) for one in recorded]
    kept = ControlLoop(Controller(robot))
    assert len(list(actions(iter(unheard), kept))) == len(unheard)
    assert kept.controller.contacts.normal_force.sum() > 0.05


def recorded_tick(
    index: int, action: Action, goal: Array, orders: tuple[OperatorCommand, ...]
) -> RecordedTick:
    """A tick as a log has it.

    Args:
        index: number.
        action: of the loop.
        goal: (3,) of its only effector.
        orders: of the operator before it.
    """
    left, x, y, z = action.actuation, *goal.tolist()
    tick = Tick(
        stamp=1, frame="base", index=index, mode=action.mode, cause=action.cause, status="OK",
        goal=((x, y, z),), correction=(), target_stamp=0, lateness=0.0, latency=0.0, decide=0.0, step=0.0,
        slack=0.0, skipped=0, goal_values=(x, y, z), deepest_gap=0.0, complementarity=0.0, stationarity=0.0,
        extra_columns=0, clamped=left.clamped,
    )  # fmt: skip
    joints = Joints(1, "base", ("tendon",), tuple(left.position), tuple(left.effort))
    return RecordedTick(tick, joints, orders)
