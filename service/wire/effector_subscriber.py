"""Subscriber to targets or measurements of effectors: decodes, checks and counts them; the latest is used.

Zenoh keeps the last samples of a key in a ring outside the interpreter, and writes down when each one
arrived; the loop reads the ring at its tick. So a flood of messages costs the loop a bounded time, no other
thread runs Python code, and the age of a message does not depend on when the loop reads it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np
import zenoh

from tauten.model import EffectorLayout
from tauten.model.numerics import Array, Bools
from tauten.model.schema import EffectorKind
from tauten.service.codec import MAX_PAYLOAD, MessageCounts, Rejection, RejectionReason, quoted
from tauten.service.wire.effector_messages import EffectorMessage, decode_effector
from tauten.service.wire.interpolation import TargetCourse

# Samples of a key that are read ahead of a tick, and again when it is due; older ones are dropped unread.
EFFECTOR_RING = 64
# Two clocks whose difference is larger do not agree: then a time of the other clock is not used for the age.
CLOCKS_AGREE = 600.0  # s
_NANO = 1e-9

Ring = zenoh.Subscriber[zenoh.handlers.Handler[zenoh.Sample]]


@dataclass(frozen=True, slots=True)
class Received:
    """A target or measurement that was accepted.

    Attributes:
        effector: its number.
        payload: the message as it came.
        encoding: of the message.
        message: the decoded message.
        age: seconds since it was made or arrived, whichever is longer.
    """

    effector: int
    payload: bytes
    encoding: str
    message: EffectorMessage
    age: float


class EffectorSubscriber:
    """Collects values of a robot's effectors, targets or measurements.

    Attributes:
        counts: messages, accepted and refused by reason.
        stamp: time in the header of the message accepted last [ns since the epoch].
        fresh: whether a message has been accepted since `take_fresh`.
    """

    def __init__(
        self,
        sources: Sequence[Ring],
        frame: str,
        layout: EffectorLayout,
        rest: Array,
        reach: float,
        timeout: float,
        delay: float = 0.0,
    ) -> None:
        """Start without messages.

        Args:
            sources: rings of samples, one for each effector.
            frame: the only frame accepted, beside an empty one.
            layout: kinds of the effectors.
            rest: (n_v,) their values at rest.
            reach: positions farther than this from the effector at rest are refused, and scalars that
                differ by as much, in metres by the layout's units [m].
            timeout: age from which on a message is not used [s].
            delay: with which values are interpolated between messages [s]; 0: the latest are used.
        """
        self.counts = MessageCounts()
        self.stamp = 0
        self.fresh = False
        self._sources = tuple(sources)
        self._frame = frame
        self._layout = layout
        self._rest = rest.copy()  # (n_v,)
        self._reach = reach
        self._timeout = timeout
        self._values = np.full_like(rest, np.nan)  # (n_v,), NaN before the first
        self._made = [-math.inf] * len(layout)  # monotonic time of the latest of each effector [s]
        self._stamps = [0] * len(layout)  # and the time in its header [ns since the epoch]
        self._early: list[list[zenoh.Sample]] = [[] for _ in layout.names]  # for the next `read`
        self._course = TargetCourse(layout, delay, timeout) if delay > 0.0 else None

    def read(self, now: float, wall: float, late: float = 0.0) -> list[Received]:
        """Read what has arrived; returns what was accepted, oldest first.

        Args:
            now: monotonic time [s].
            wall: time since the Unix epoch [s].
            late: how long ago this was due [s]. What has arrived since waits for the next call, so that goals
                of a stream change evenly: not by twice as much in a late tick, and then not at all.
        """
        accepted: list[Received] = []
        for effector in range(len(self._sources)):
            for sample in self._due(effector, wall, late):
                found = self._checked(effector, sample, wall)
                if isinstance(found, Received):
                    found = self._in_order(found, now)
                if isinstance(found, Rejection):
                    self.counts.refuse(found)
                    continue
                accepted.append(found)
                self._values[self._layout.values_of(effector)] = found.message.values
                self._made[effector] = now - found.age
                self._stamps[effector] = found.message.stamp
                if self._course is not None:
                    self._course.add(effector, now - found.age, found.message.values)
                self.stamp = found.message.stamp
        self.fresh = self.fresh or bool(accepted)
        self.counts.accepted += len(accepted)
        return accepted

    def take_fresh(self) -> bool:
        """Whether a message has been accepted since the last call."""
        fresh, self.fresh = self.fresh, False
        return fresh

    def latest(self, now: float, default: Array) -> Array | None:
        """Goal values (n_v,) at a monotonic time [s]; None when none is young enough.

        Each effector's message counts for itself: no other one's keeps it alive. Effectors without one that
        is young enough have their default (n_v,).
        """
        young = [now - made <= self._timeout for made in self._made]
        if not any(young):
            return None
        if self._course is not None:
            return self._course.at(now, default, young)
        values = default.copy()
        for effector, counts in enumerate(young):
            if counts:
                part = self._layout.values_of(effector)
                values[part] = self._values[part]
        return values

    def followed(self, now: float) -> Bools:
        """Rows (n_e,) of effectors with a message that is young enough at a monotonic time [s]."""
        rows = np.zeros(self._layout.n_rows, np.bool_)
        for effector, made in enumerate(self._made):
            rows[self._layout.rows_of(effector)] = now - made <= self._timeout
        return rows

    def outdated(self, now: float) -> tuple[str, ...]:
        """Names of the effectors whose last message is too old at a monotonic time [s]."""
        return tuple(
            name
            for name, made in zip(self._layout.names, self._made, strict=True)
            if -math.inf < made < now - self._timeout
        )

    def complete(self, now: float) -> Array | None:
        """Values (n_v,); None unless those of every effector are young enough at a monotonic time [s]."""
        if now - min(self._made) > self._timeout:
            return None
        return self._values.copy()

    def ages(self, now: float) -> list[float]:
        """Ages of the effectors' latest messages [s]; infinity before the first one."""
        return [now - made for made in self._made]

    def oldest(self, now: float) -> float:
        """The largest of these."""
        return max(self.ages(now))

    def _due(self, effector: int, wall: float, late: float) -> Iterator[zenoh.Sample]:
        """Samples of an effector that had arrived when `read` was due, with what the last call left."""
        left, self._early[effector] = self._early[effector], []
        yield from left
        for sample in waiting(self._sources[effector], EFFECTOR_RING):
            early = self._early[effector]
            if early or (late > 0.0 and arrived_before(sample, wall) < late):
                early.append(sample)
            else:
                yield sample

    def _checked(self, effector: int, sample: zenoh.Sample, wall: float) -> Received | Rejection:
        """A sample decoded, and checked for what does not depend on the others."""
        kind, name = self._layout.kinds[effector], self._layout.names[effector]
        message = message_in(sample, kind, name, self._frame)
        if isinstance(message, Rejection):
            return message
        detail = self._out_of_reach(effector, message.values)
        if detail:
            return Rejection(RejectionReason.OUT_OF_REACH, detail)
        age = age_by(_NANO * message.stamp, wall)
        if sample.timestamp is not None:
            age = max(age, arrived_before(sample, wall))
        if age > self._timeout:
            detail = (
                f"made or arrived {age:.3g} s ago, allowed are {self._timeout:g} s; "
                "do the clocks of sender and node agree?"
            )
            return Rejection(RejectionReason.TOO_OLD, detail)
        return Received(effector, bytes(sample.payload), str(sample.encoding), message, age)

    def _in_order(self, found: Received, now: float) -> Received | Rejection:
        """A message, unless a newer one of its effector counts already."""
        effector, stamp = found.effector, found.message.stamp
        earlier = self._stamps[effector] - stamp  # ns
        if stamp == 0 or earlier <= 0 or now - self._made[effector] > self._timeout:
            return found
        detail = f"made {_NANO * earlier:.3g} s before the one that arrived before it"
        return Rejection(RejectionReason.TOO_OLD, detail)

    def _out_of_reach(self, effector: int, values: tuple[float, ...]) -> str:
        """Why values cannot be reached by far; "" where they may be."""
        layout, rest = self._layout, self._rest[self._layout.values_of(effector)]
        if len(values) > 1:
            distance = math.dist(values[:3], rest[:3])
            if not distance <= self._reach:
                return (
                    f"{distance:.3g} m from the effector at rest, allowed are {self._reach:.3g} m"
                )
            return ""
        kind = layout.kinds[effector]
        reach = self._reach / float(layout.units[layout.rows_of(effector).start])
        least, most = rest[0] - reach, rest[0] + reach
        if kind != "function":  # which may be negative
            least = max(least, 0.0)
        if not least <= values[0] <= most:
            size = "m³" if kind == "volume" else "m"
            return (
                f"a {kind} of {values[0]:.3g} {size}, allowed are {least:.3g} to {most:.3g} {size}"
            )
        return ""


def age_by(made: float, wall: float) -> float:
    """Seconds since a time of another clock; 0 where that does not agree with this clock's.

    Both are times since the Unix epoch [s].
    """
    age = wall - made
    return age if 0.0 < age <= CLOCKS_AGREE else 0.0


def arrived_before(sample: zenoh.Sample, wall: float) -> float:
    """Seconds from a sample's arrival to this clock's time [s]; infinity where Zenoh has not noted it."""
    if sample.timestamp is None:
        return math.inf
    return age_by(sample.timestamp.get_time().timestamp(), wall)


def waiting(source: Ring, most: int) -> Iterator[zenoh.Sample]:
    """Samples that have arrived, oldest first, not more than some."""
    return islice(iter(source.try_recv, None), most)


def message_in(
    sample: zenoh.Sample, kind: EffectorKind, name: str, frame: str
) -> EffectorMessage | Rejection:
    """Values of an effector, or of an obstacle as of a frame, in a sample that has arrived.

    The frame is the only one accepted, beside an empty one.
    """
    payload = payload_of(sample)
    if isinstance(payload, Rejection):
        return payload
    message = decode_effector(kind, name, payload, str(sample.encoding))
    if isinstance(message, Rejection) or message.frame in ("", frame):
        return message
    detail = f"found frame {quoted(message.frame)}, expected {frame!r}"
    return Rejection(RejectionReason.WRONG_FRAME, detail)


def payload_of(sample: zenoh.Sample, allowed: int = MAX_PAYLOAD) -> bytes | Rejection:
    """The bytes of a sample; one with more than are allowed is not copied."""
    payload = sample.payload
    size = len(payload)
    if size > allowed:
        return Rejection(RejectionReason.TOO_LARGE, f"{size} bytes, allowed are {allowed}")
    return bytes(payload)


def reach_of(size: float) -> float:
    """Distance from rest beyond which a target is a mistake, a wrong unit for instance [m].

    The size is the largest distance between two of the robot's nodes at rest [m]. A tip cannot leave the ball
    of its body's length around the base; twice that permits targets that are only nearly reachable, which the
    controller approaches as far as it can.
    """
    return 2.0 * size
