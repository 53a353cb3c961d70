"""The node's state machine: IDLE → RUN → HOLD → STOP, as pure functions of what a tick has seen.

docs/node.md draws it. Nothing here knows of time, network or cables: `commanded` takes an operator's
command, `transition` what the tick has seen, `judged` how its decision ended.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from tauten.service.wire import Cause, Mode, OperatorCommand


@dataclass(frozen=True, slots=True)
class Signals:
    """What a tick has seen.

    Attributes:
        target: whether a target young enough is there.
        in_time: whether the tick before met its deadline.
        measured: whether every measurement that is needed is young enough.
        shutdown: whether the process was asked to end.
    """

    target: bool
    in_time: bool = True
    measured: bool = True
    shutdown: bool = False


@dataclass(frozen=True, slots=True)
class NodeState:
    """NodeState of the node.

    Attributes:
        mode: what it is doing.
        cause: why it does not follow; `NONE` while it does.
        enabled: whether the operator lets it follow.
        late: deadlines missed in a row; while `tripped`, how many more must be met than missed.
        tripped: whether too many were missed.
    """

    mode: Mode = Mode.IDLE
    cause: Cause = Cause.NO_TARGET
    enabled: bool = True
    late: int = 0
    tripped: bool = False


def commanded(state: NodeState, command: OperatorCommand, released: bool) -> NodeState | None:
    """The state after an operator's command; None where the command is not possible.

    Args:
        state: before.
        command: the operator's.
        released: whether the cables are slack after a stop.
    """
    if command is OperatorCommand.STOP:
        return replace(state, mode=Mode.STOP, cause=Cause.OPERATOR)
    if command is OperatorCommand.RESET:
        return NodeState() if state.mode is Mode.STOP and released else None
    if state.mode is Mode.STOP:
        return None
    return replace(state, enabled=command is OperatorCommand.ENABLE)


def transition(state: NodeState, seen: Signals, late_limit: int) -> NodeState:
    """The state in which a tick acts: RUN asks for a decision, all others for none.

    Args:
        state: before.
        seen: by the tick.
        late_limit: deadlines missed in a row that trip the node; it is free again once as many more have
            been met than missed.
    """
    if seen.shutdown:
        return replace(state, mode=Mode.STOP, cause=Cause.SHUTDOWN)
    if state.mode is Mode.STOP:
        return state
    state = _counted(state, seen.in_time, late_limit)
    cause = _obstacle(state, seen)
    still = Mode.IDLE if state.mode is Mode.IDLE else Mode.HOLD
    mode = Mode.RUN if cause is Cause.NONE else still
    if (mode, cause) == (state.mode, state.cause):
        return state
    return replace(state, mode=mode, cause=cause)


def judged(state: NodeState, usable: bool) -> NodeState:
    """The state after a decision in RUN: one that cannot be used holds the winches.

    The next tick tries again, so that a target back in reach is followed.
    """
    if state.mode is not Mode.RUN or usable:
        return state
    return replace(state, mode=Mode.HOLD, cause=Cause.UNUSABLE)


def _counted(state: NodeState, in_time: bool, limit: int) -> NodeState:
    if state.tripped:
        late = state.late - 1 if in_time else min(state.late + 1, limit)
        return replace(state, late=late, tripped=late > 0)
    late = 0 if in_time else state.late + 1
    if late == state.late:
        return state
    return replace(state, late=late, tripped=late >= limit)


def _obstacle(state: NodeState, seen: Signals) -> Cause:
    """What keeps the node from following, the most serious first."""
    if not state.enabled:
        return Cause.OPERATOR
    if state.tripped:
        return Cause.LATE
    if not seen.measured:
        return Cause.UNMEASURED
    return Cause.NONE if seen.target else Cause.NO_TARGET
