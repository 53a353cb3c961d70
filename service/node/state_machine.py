"""The node's state machine: IDLE → RUN → HOLD → STOP, as pure functions of the inputs of a tick.

Its diagram is in docs/node.md. Time, network and cables are not part of it: `commanded` is for an operator's
command, `transition` for the inputs of a tick, `judged` for the result of its decision.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from tauten.service.wire import Cause, Mode, OperatorCommand


@dataclass(frozen=True, slots=True)
class Signals:
    """Inputs of a tick.

    Attributes:
        target: whether there is a target that is young enough.
        in_time: whether the tick before met its deadline.
        measurement: why the measurements of a closed loop cannot be used; `NONE` where they can.
        shutdown: whether the process is requested to end.
        hurried: whether there was a second request: then the cables are released as fast as they may be.
    """

    target: bool
    in_time: bool = True
    measurement: Cause = Cause.NONE
    shutdown: bool = False
    hurried: bool = False


@dataclass(frozen=True, slots=True)
class NodeState:
    """State of the node.

    Attributes:
        mode: of the node.
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

    After a stop a reset is possible once the cables have been released.
    """
    if command is OperatorCommand.STOP:
        return replace(state, mode=Mode.STOP, cause=Cause.OPERATOR)
    if command is OperatorCommand.RESET:
        return NodeState() if state.mode is Mode.STOP and released else None
    if state.mode is Mode.STOP:
        return None
    if command is OperatorCommand.LET_GO:
        return state
    return replace(state, enabled=command is OperatorCommand.ENABLE)


def transition(state: NodeState, seen: Signals, late_limit: int) -> NodeState:
    """The state in which a tick acts: only RUN needs a decision.

    Args:
        state: before.
        seen: inputs of the tick.
        late_limit: deadlines missed in a row after which the node holds; until as many more have been met
            than missed.
    """
    if seen.shutdown:
        cause = Cause.HURRIED if seen.hurried else Cause.SHUTDOWN
        return replace(state, mode=Mode.STOP, cause=cause)
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
    return replace(state, late=late, tripped=late >= limit)


def _obstacle(state: NodeState, seen: Signals) -> Cause:
    """Why the node cannot follow, the most serious cause first."""
    if not state.enabled:
        return Cause.OPERATOR
    if state.tripped:
        return Cause.LATE
    if seen.measurement is not Cause.NONE:
        return seen.measurement
    return Cause.NONE if seen.target else Cause.NO_TARGET
