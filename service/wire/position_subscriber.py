"""Positions as they arrive, targets or measurements: decoded, judged, counted; the latest count.

Zenoh keeps the last samples of a key in a ring of its own, outside the interpreter; the loop takes
them out at its tick. So a flood of targets costs the loop a bounded time, and no other thread runs
Python code.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
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

# Samples of a key looked at ahead of a tick, and again when it is due; older ones are dropped unseen.
POSITION_RING = 64


class Payload(Protocol):
    """What the inbox reads of zenoh.ZBytes."""

    def __len__(self) -> int:
        """Bytes."""

    def __bytes__(self) -> bytes:
        """A copy."""


class Sample(Protocol):
    """What the inbox reads of a zenoh.Sample."""

    @property
    def payload(self) -> Payload:
        """What was sent."""

    @property
    def encoding(self) -> object:
        """Its text names the encoding."""


class Source(Protocol):
    """What the inbox reads of a zenoh.Subscriber with a ring."""

    def try_recv(self) -> Sample | None:
        """The next sample, or None."""


@dataclass(frozen=True, slots=True)
class Received:
    """A position that was accepted: which effector, the message as it came, and what it says."""

    effector: int
    payload: bytes
    encoding: str
    point: Point


@dataclass(frozen=True, slots=True)
class Goal:
    """What the controller is asked for.

    Attributes:
        positions: (p, 3) of the effectors [m].
        stamp: time in the header of the target that arrived last [ns since the epoch].
        fresh: whether a target arrived for this tick.
    """

    positions: Array
    stamp: int
    fresh: bool


class PositionSubscriber:
    """Collects positions of a robot's effectors.

    Attributes:
        tally: counts by what became of them.
        fresh: whether any arrived for this tick.
    """

    def __init__(
        self, sources: Sequence[Source], frame: str, rest: Array, reach: float, timeout: float
    ) -> None:
        """Listen.

        Args:
            sources: one an effector.
            frame: the only frame accepted, beside an empty one.
            rest: (p, 3) effectors at rest [m].
            reach: positions farther than this from where the effector rests are refused [m].
            timeout: age from which on a position counts no more [s].
        """
        self.tally = MessageCounts()
        self._sources = tuple(sources)
        self._frame = frame
        self._rest = rest.copy()  # (p, 3)
        self._reach = reach
        self._timeout = timeout
        self._positions = np.full_like(rest, np.nan)  # (p, 3), NaN before the first
        self._stamp = 0
        self._arrived = [-math.inf] * len(rest)  # when the last one came [s]
        self.fresh = False

    def drain(self, now: float, again: bool = False) -> list[Received]:
        """Take what has arrived; returns what was accepted, oldest first.

        Args:
            now: monotonic time [s].
            again: whether this tick has drained before; what came then is fresh still.
        """
        accepted: list[Received] = []
        for effector, source in enumerate(self._sources):
            for _ in range(POSITION_RING):
                sample = source.try_recv()
                if sample is None:
                    break
                found = self._read(effector, sample)
                if isinstance(found, Rejection):
                    self.tally.refuse(found)
                else:
                    accepted.append(found)
        for item in accepted:
            self._positions[item.effector] = item.point.xyz
            self._arrived[item.effector] = now
            self._stamp = item.point.stamp
        self.fresh = bool(accepted) or (again and self.fresh)
        self.tally.accepted += len(accepted)
        return accepted

    def goal(self, now: float, effectors: Array) -> Goal | None:
        """The goal; None when no target is young enough.

        Args:
            now: monotonic time [s].
            effectors: (p, 3) where they are [m]; one that never got a target is asked to stay there.
        """
        if now - max(self._arrived) > self._timeout:
            return None
        positions = self._positions.copy()
        for effector, arrived in enumerate(self._arrived):
            if arrived == -math.inf:
                positions[effector] = effectors[effector]
        return Goal(positions, self._stamp, self.fresh)

    def complete(self, now: float) -> Array | None:
        """Positions (p, 3) [m]; None unless that of every effector is young enough.

        Args:
            now: monotonic time [s].
        """
        if now - min(self._arrived) > self._timeout:
            return None
        return self._positions.copy()

    def _read(self, effector: int, sample: Sample) -> Received | Rejection:
        payload = payload_of(sample)
        if isinstance(payload, Rejection):
            return payload
        return self.judge(effector, payload, str(sample.encoding))

    def judge(self, effector: int, payload: bytes, encoding: str) -> Received | Rejection:
        """Decode a position and check what does not depend on the others."""
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
        return Received(effector, payload, encoding, point)


def payload_of(sample: Sample) -> bytes | Rejection:
    """The bytes of a sample; one that is too large is not even copied."""
    payload = sample.payload
    size = len(payload)
    if size > MAX_PAYLOAD:
        return Rejection(RejectionReason.TOO_LARGE, f"{size} bytes, allowed are {MAX_PAYLOAD}")
    return bytes(payload)


def reach_of(size: float) -> float:
    """Distance from rest beyond which a target is a mistake, a wrong unit for instance [m].

    Args:
        size: diagonal of the robot's bounding box [m].

    A tip cannot leave the ball of its body's length around the base; twice that leaves room for
    targets that are only nearly reachable, which the controller approaches as far as it can.
    """
    return 2.0 * size
