"""Subscriber to positions, targets or measurements: decodes, checks and counts them; the latest is used.

Zenoh keeps the last samples of a key in a ring outside the interpreter, and writes down when each one
arrived; the loop reads the ring at its tick. So a flood of positions costs the loop a bounded time, no other
thread runs Python code, and the age of a position does not depend on when the loop reads it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Protocol

import numpy as np

from tauten.model.numerics import Array
from tauten.service.wire.health import MessageCounts
from tauten.service.wire.messages import (
    MAX_PAYLOAD,
    Point,
    Rejection,
    RejectionReason,
    decode_point,
)

# Samples of a key that are read ahead of a tick, and again when it is due; older ones are dropped unread.
POSITION_RING = 64
# Two clocks whose difference is larger do not agree: then a time of the other clock is not used for the age.
CLOCKS_AGREE = 600.0  # s
_NANO = 1e-9


class Payload(Protocol):
    """The part of zenoh.ZBytes that is used here."""

    def __len__(self) -> int:
        """Number of bytes."""

    def __bytes__(self) -> bytes:
        """A copy."""


class Timestamp(Protocol):
    """The part of zenoh.Timestamp that is used here."""

    def get_time(self) -> datetime:
        """The time."""


class Sample(Protocol):
    """The part of a zenoh.Sample that is used here."""

    @property
    def payload(self) -> Payload:
        """The message."""

    @property
    def encoding(self) -> object:
        """Its text names the encoding."""

    @property
    def timestamp(self) -> Timestamp | None:
        """Time of arrival, or of sending where the sender or a router has written one."""


class Source(Protocol):
    """The part of a zenoh.Subscriber with a ring that is used here."""

    def try_recv(self) -> Sample | None:
        """The next sample, or None."""


@dataclass(frozen=True, slots=True)
class Received:
    """A position that was accepted.

    Attributes:
        effector: its number.
        payload: the message as it came.
        encoding: of the message.
        point: the decoded message.
        age: seconds since it was made or arrived, whichever is longer.
    """

    effector: int
    payload: bytes
    encoding: str
    point: Point
    age: float


class PositionSubscriber:
    """Collects positions of a robot's effectors.

    Attributes:
        counts: messages, accepted and refused by reason.
        stamp: time in the header of the position accepted last [ns since the epoch].
        fresh: whether a position has been accepted since `take_fresh`.
    """

    def __init__(
        self, sources: Sequence[Source], frame: str, rest: Array, reach: float, timeout: float
    ) -> None:
        """Start without positions.

        Args:
            sources: rings of samples, one for each effector.
            frame: the only frame accepted, beside an empty one.
            rest: (p, 3) effectors at rest [m].
            reach: positions farther than this from the effector at rest are refused [m].
            timeout: age from which on a position is not used [s].
        """
        self.counts = MessageCounts()
        self.stamp = 0
        self.fresh = False
        self._sources = tuple(sources)
        self._frame = frame
        self._rest = rest.copy()  # (p, 3)
        self._reach = reach
        self._timeout = timeout
        self._positions = np.full_like(rest, np.nan)  # (p, 3), NaN before the first
        self._made = [-math.inf] * len(rest)  # monotonic time of the latest of each effector [s]

    def read(self, now: float, wall: float) -> list[Received]:
        """Read what has arrived; returns what was accepted, oldest first.

        Args:
            now: monotonic time [s].
            wall: time since the Unix epoch [s].
        """
        accepted: list[Received] = []
        for effector, source in enumerate(self._sources):
            for _ in range(POSITION_RING):
                sample = source.try_recv()
                if sample is None:
                    break
                found = self._checked(effector, sample, wall)
                if isinstance(found, Rejection):
                    self.counts.refuse(found)
                    continue
                accepted.append(found)
                self._positions[effector] = found.point.xyz
                self._made[effector] = now - found.age
                self.stamp = found.point.stamp
        self.fresh = self.fresh or bool(accepted)
        self.counts.accepted += len(accepted)
        return accepted

    def take_fresh(self) -> bool:
        """Whether a position has been accepted since the last call."""
        fresh, self.fresh = self.fresh, False
        return fresh

    def latest(self, now: float, default: Array) -> Array | None:
        """Positions (p, 3) [m]; None when none is young enough.

        Args:
            now: monotonic time [s].
            default: (p, 3) for effectors without any position yet [m].
        """
        if now - max(self._made) > self._timeout:
            return None
        positions = self._positions.copy()
        for effector, made in enumerate(self._made):
            if made == -math.inf:
                positions[effector] = default[effector]
        return positions

    def complete(self, now: float) -> Array | None:
        """Positions (p, 3) [m]; None unless that of every effector is young enough.

        Args:
            now: monotonic time [s].
        """
        if now - min(self._made) > self._timeout:
            return None
        return self._positions.copy()

    def oldest(self, now: float) -> float:
        """Largest age of the effectors' latest positions [s]; infinity before each has one."""
        return now - min(self._made)

    def _checked(self, effector: int, sample: Sample, wall: float) -> Received | Rejection:
        """A sample decoded, and checked for what does not depend on the others."""
        payload = payload_of(sample)
        if isinstance(payload, Rejection):
            return payload
        encoding = str(sample.encoding)
        point = decode_point(payload, encoding)
        if isinstance(point, Rejection):
            return point
        if point.frame not in ("", self._frame):
            detail = f"found frame {point.frame[:40]!r}, expected {self._frame!r}"
            return Rejection(RejectionReason.WRONG_FRAME, detail)
        distance = math.dist(point.xyz, self._rest[effector])
        if not distance <= self._reach:
            detail = f"{distance:.3g} m from the effector at rest, allowed are {self._reach:.3g} m"
            return Rejection(RejectionReason.OUT_OF_REACH, detail)
        age = age_by(_NANO * point.stamp, wall)
        if sample.timestamp is not None:
            age = max(age, age_by(sample.timestamp.get_time().timestamp(), wall))
        if age > self._timeout:
            detail = (
                f"made or arrived {age:.3g} s ago, allowed are {self._timeout:g} s; "
                "do the clocks of sender and node agree?"
            )
            return Rejection(RejectionReason.TOO_OLD, detail)
        return Received(effector, payload, encoding, point, age)


def age_by(made: float, wall: float) -> float:
    """Seconds since a time that another clock has written; 0 where that clock does not agree with this one.

    Args:
        made: the other clock's time since the Unix epoch [s].
        wall: this clock's time [s].
    """
    age = wall - made
    return age if 0.0 < age <= CLOCKS_AGREE else 0.0


def payload_of(sample: Sample) -> bytes | Rejection:
    """The bytes of a sample; one that is too large is not copied."""
    payload = sample.payload
    size = len(payload)
    if size > MAX_PAYLOAD:
        return Rejection(RejectionReason.TOO_LARGE, f"{size} bytes, allowed are {MAX_PAYLOAD}")
    return bytes(payload)


def reach_of(size: float) -> float:
    """Distance from rest beyond which a target is a mistake, a wrong unit for instance [m].

    Args:
        size: diagonal of the robot's bounding box [m].

    A tip cannot leave the ball of its body's length around the base; twice that permits targets that are
    only nearly reachable, which the controller approaches as far as it can.
    """
    return 2.0 * size
