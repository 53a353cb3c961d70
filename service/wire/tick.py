"""One tick of the node: enough to draw it, to examine it and to replay it.

Every tick carries the goal that its decision used, or none when the node held, so that a replay does not
depend on when a target arrived.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tauten.controller.qpcc import Status
from tauten.service.codec import (
    TICK,
    Rejection,
    RejectionReason,
    from_cdr,
    header,
    nanoseconds,
    new,
    quoted,
    time_message,
    to_cdr,
)
from tauten.service.link import Cause, Mode

_MODES, _CAUSES = frozenset(Mode), frozenset(Cause)
_STATUSES = frozenset({"", *Status.__members__})
# fields that are the same in a tick and in its message
_ALIKE = (
    "status", "lateness", "latency", "decide", "step", "slack", "skipped", "deepest_gap",
    "complementarity", "stationarity", "extra_columns", "clamped",
)  # fmt: skip

Positions = tuple[tuple[float, float, float], ...]


@dataclass(frozen=True, slots=True)
class Tick:
    """One tick of the node.

    Attributes:
        stamp: when the actuation left [ns since the epoch].
        frame: frame of the goal.
        index: ticks since the start.
        mode: of the node.
        cause: why it did not follow.
        status: name of the decision's `Status`, "" when nothing was decided.
        goal: positions wanted, one an effector [m]; empty when nothing was decided. For drawing; of a
            distance, length or volume, where it is in the model.
        correction: added to the goal in a closed loop, one an effector [m]; empty in an open one.
        target_stamp: time in the target's header [ns since the epoch], 0 without.
        lateness: how late the tick began [s].
        latency: from the target's header to the actuation, on the first tick that used it; NaN on
            others, and where the two clocks do not agree [s].
        decide: time `decide` took [s].
        step: time `decide`, `advance` and `prepare` took together [s].
        slack: time that was left of the tick before this one; negative: a missed deadline [s].
        skipped: ticks lost before this one.
        deepest_gap: smallest gap predicted, +inf without any in range, NaN while releasing [m].
        complementarity: certificate of the decision or of the hold.
        stationarity: certificate of the decision or of the hold.
        extra_columns: contacts that joined the basis for this tick.
        clamped: whether the limiter changed the actuation.
        goal_values: goal values of all effectors, see `tauten.model.EffectorLayout`; empty when nothing
            was decided.
        correction_values: of all effector rows, added to the goal in a closed loop; empty in an open one.
        checks: of the time that a decision with friction passed before it was cut; −1: it was not. A replay
            cuts it there.
    """

    stamp: int
    frame: str
    index: int
    mode: Mode
    cause: Cause
    status: str
    goal: Positions
    correction: Positions
    target_stamp: int
    lateness: float
    latency: float
    decide: float
    step: float
    slack: float
    skipped: int
    deepest_gap: float
    complementarity: float
    stationarity: float
    extra_columns: int
    clamped: bool
    goal_values: tuple[float, ...] = ()
    correction_values: tuple[float, ...] = ()
    checks: int = -1


def encode_tick(tick: Tick) -> bytes:
    """A tick in CDR."""

    def points(positions: Positions) -> list[Any]:
        return [new("geometry_msgs/msg/Point", x=x, y=y, z=z) for x, y, z in positions]

    message = new(
        TICK,
        header=header(tick.stamp, tick.frame),
        tick=tick.index,
        mode=tick.mode.value,
        cause=tick.cause.value,
        goal=points(tick.goal),
        correction=points(tick.correction),
        target_stamp=time_message(tick.target_stamp),
        **{name: getattr(tick, name) for name in _ALIKE},
        goal_values=np.array(tick.goal_values, dtype=np.float64),
        correction_values=np.array(tick.correction_values, dtype=np.float64),
        checks=tick.checks,
    )
    return to_cdr(TICK, message)


def decode_tick(payload: bytes) -> Tick | Rejection:
    """A tick from CDR."""
    message: Any = from_cdr(TICK, payload)
    if isinstance(message, Rejection):
        return message
    for what, found, allowed in (
        ("mode", message.mode, _MODES),
        ("cause", message.cause, _CAUSES),
        ("status", message.status, _STATUSES),
    ):
        if found not in allowed:
            return Rejection(RejectionReason.MALFORMED, f"no {what} {quoted(found)}")
    goal = tuple((point.x, point.y, point.z) for point in message.goal)
    correction = tuple((point.x, point.y, point.z) for point in message.correction)
    return Tick(
        stamp=nanoseconds(message.header.stamp),
        frame=message.header.frame_id,
        index=message.tick,
        mode=Mode(message.mode),
        cause=Cause(message.cause),
        goal=goal,
        correction=correction,
        target_stamp=nanoseconds(message.target_stamp),
        **{name: getattr(message, name) for name in _ALIKE},
        goal_values=tuple(message.goal_values.tolist()),
        correction_values=tuple(message.correction_values.tolist()),
        checks=message.checks,
    )
