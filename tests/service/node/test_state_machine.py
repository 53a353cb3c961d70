"""The state machine: each transition, and what no sequence of events can break."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tauten.service.node import Signals
from tauten.service.node.state_machine import NodeState, commanded, judged, transition
from tauten.service.wire import Cause, Mode, OperatorCommand

LIMIT = 3
TARGET, NOTHING = Signals(target=True), Signals(target=False)
LATE = Signals(target=True, in_time=False)
RUNNING = transition(NodeState(), TARGET, LIMIT)


def after(state: NodeState, *seen: Signals) -> NodeState:
    for signals in seen:
        state = transition(state, signals, LIMIT)
    return state


def test_a_target_starts_it_and_its_absence_holds_it() -> None:
    assert after(NodeState(), NOTHING).mode is Mode.IDLE
    assert NodeState(Mode.RUN, Cause.NONE) == RUNNING
    held = after(RUNNING, NOTHING)
    assert (held.mode, held.cause) == (Mode.HOLD, Cause.NO_TARGET)
    assert after(held, TARGET) == RUNNING


def test_a_bad_decision_holds_until_one_can_be_used() -> None:
    held = judged(RUNNING, usable=False)
    assert (held.mode, held.cause) == (Mode.HOLD, Cause.UNUSABLE)
    assert judged(after(held, TARGET), usable=True) == RUNNING


def test_a_missing_measurement_holds() -> None:
    held = after(RUNNING, Signals(target=True, measurement=Cause.UNMEASURED))
    assert (held.mode, held.cause) == (Mode.HOLD, Cause.UNMEASURED)
    assert after(held, TARGET) == RUNNING
    idle = after(NodeState(), Signals(target=True, measurement=Cause.UNMEASURED))
    assert (idle.mode, idle.cause) == (Mode.IDLE, Cause.UNMEASURED)


def test_deadlines_missed_in_a_row_hold_until_as_many_more_are_met() -> None:
    assert after(RUNNING, LATE, LATE).mode is Mode.RUN
    assert after(RUNNING, LATE, LATE, TARGET, LATE, LATE).mode is Mode.RUN  # not in a row
    held = after(RUNNING, LATE, LATE, LATE)
    assert (held.mode, held.cause) == (Mode.HOLD, Cause.LATE)
    assert after(held, TARGET, TARGET).mode is Mode.HOLD
    assert after(held, TARGET, TARGET, LATE, TARGET).mode is Mode.HOLD
    assert after(held, TARGET, TARGET, LATE, TARGET, TARGET) == RUNNING
    assert after(held, *[LATE] * 10, TARGET, TARGET, TARGET) == RUNNING  # not punished for ever


def test_an_operator_holds_stops_and_resets() -> None:
    held = commanded(RUNNING, OperatorCommand.HOLD, released=False)
    assert held is not None
    assert after(held, TARGET).cause is Cause.OPERATOR
    enabled = commanded(after(held, TARGET), OperatorCommand.ENABLE, released=False)
    assert enabled is not None
    assert after(enabled, TARGET) == RUNNING
    stopped = commanded(RUNNING, OperatorCommand.STOP, released=False)
    assert stopped is not None
    assert after(stopped, TARGET, TARGET).mode is Mode.STOP
    for command in (OperatorCommand.ENABLE, OperatorCommand.HOLD):
        assert commanded(stopped, command, released=True) is None
    assert commanded(stopped, OperatorCommand.RESET, released=False) is None
    assert commanded(stopped, OperatorCommand.RESET, released=True) == NodeState()
    assert commanded(RUNNING, OperatorCommand.RESET, released=True) is None


def test_a_node_that_waits_is_idle_until_enabled() -> None:
    waiting = after(NodeState(enabled=False), TARGET)
    assert (waiting.mode, waiting.cause) == (Mode.IDLE, Cause.OPERATOR)
    enabled = commanded(waiting, OperatorCommand.ENABLE, released=False)
    assert enabled is not None
    assert after(enabled, TARGET) == RUNNING


@pytest.mark.parametrize("mode", list(Mode))
def test_a_shutdown_stops_from_everywhere(mode: Mode) -> None:
    state = after(replace(NodeState(), mode=mode), replace(NOTHING, shutdown=True))
    assert (state.mode, state.cause) == (Mode.STOP, Cause.SHUTDOWN)
    state = after(state, replace(NOTHING, shutdown=True, hurried=True))
    assert (state.mode, state.cause) == (Mode.STOP, Cause.HURRIED)


signals = st.builds(
    Signals,
    target=st.booleans(),
    in_time=st.booleans(),
    measurement=st.sampled_from([Cause.NONE, Cause.UNMEASURED, Cause.IMPLAUSIBLE]),
)
events = st.lists(signals | st.sampled_from(list(OperatorCommand)) | st.booleans(), max_size=40)


@given(events)
def test_it_runs_only_when_everything_allows_it(
    wanted: list[Signals | OperatorCommand | bool],
) -> None:
    """Commands, ticks and verdicts (booleans) in any order."""
    state, late = NodeState(), 0
    for event in wanted:
        before = state
        if isinstance(event, OperatorCommand):
            state = commanded(before, event, released=True) or before
        elif isinstance(event, bool):
            state = judged(before, event)
        else:
            state = transition(before, event, LIMIT)
            late = 0 if event.in_time else late + 1  # in a row
            if state.mode is Mode.RUN:
                assert event.target
                assert event.measurement is Cause.NONE
                assert state.enabled
                assert late < LIMIT
        assert (state.mode is Mode.RUN) == (state.cause is Cause.NONE)
        if before.mode is Mode.STOP and state.mode is not Mode.STOP:
            assert event is OperatorCommand.RESET
        if state.mode is Mode.IDLE:
            assert before.mode is Mode.IDLE or event is OperatorCommand.RESET


def test_a_let_go_changes_no_mode_and_is_refused_in_a_stop() -> None:
    """A node that follows goes on, and one that is held is not enabled by it."""
    for enabled in (True, False):
        state = NodeState(enabled=enabled)
        assert commanded(state, OperatorCommand.LET_GO, released=False) == state
    stopped = NodeState(mode=Mode.STOP, cause=Cause.OPERATOR)
    assert commanded(stopped, OperatorCommand.LET_GO, released=True) is None
