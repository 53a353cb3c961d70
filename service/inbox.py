"""Targets as they arrive: decoded, judged, counted; the latest good one is the goal.

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

from tauten.model.arrays import Array
from tauten.service.health import Tally
from tauten.service.messages import Fault, Point, Reason, decode_point

# Samples of a key looked at each tick; older ones are dropped unseen.
RING = 64


class Sample(Protocol):
    """What the inbox reads of a zenoh.Sample."""

    @property
    def payload(self) -> object:
        """Bytes-like."""

    @property
    def encoding(self) -> object:
        """Its text names the encoding."""


class Source(Protocol):
    """What the inbox reads of a zenoh.Subscriber with a ring."""

    def try_recv(self) -> Sample | None:
        """The next sample, or None."""


@dataclass(frozen=True, slots=True)
class Received:
    """A target that was accepted: which effector, the message as it came, and what it says."""

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


class Inbox:
    """Collects targets.

    Attributes:
        tally: counts by what became of them.
    """

    def __init__(
        self, sources: Sequence[Source], frame: str, rest: Array, reach: float, timeout: float
    ) -> None:
        """Listen.

        Args:
            sources: one an effector.
            frame: the only frame accepted, beside an empty one.
            rest: (p, 3) effectors at rest [m].
            reach: targets farther than this from where the effector rests are refused [m].
            timeout: age of the last target from which on there is no goal [s].
        """
        self.tally = Tally()
        self._sources = tuple(sources)
        self._frame = frame
        self._rest = rest.copy()  # (p, 3)
        self._reach = reach
        self._timeout = timeout
        self._positions = np.full_like(rest, np.nan)  # (p, 3), NaN before the first target
        self._stamp = 0
        self._last = -math.inf
        self._fresh = False

    def drain(self, now: float) -> list[Received]:
        """Take what has arrived; returns the targets that were accepted, oldest first.

        Args:
            now: monotonic time [s].
        """
        accepted: list[Received] = []
        for effector, source in enumerate(self._sources):
            for _ in range(RING):
                sample = source.try_recv()
                if sample is None:
                    break
                found = self.judge(effector, bytes(sample.payload), str(sample.encoding))  # type: ignore[call-overload]
                if isinstance(found, Fault):
                    self.tally.refuse(found)
                else:
                    accepted.append(found)
        for target in accepted:
            self._positions[target.effector] = target.point.xyz
            self._stamp = target.point.stamp
        self._fresh = bool(accepted)
        self.tally.accepted += len(accepted)
        if accepted:
            self._last = now
        return accepted

    def goal(self, now: float, effectors: Array) -> Goal | None:
        """The goal; None when no target is young enough.

        Args:
            now: monotonic time [s].
            effectors: (p, 3) where they are [m]; one that never got a target is asked to stay there.
        """
        if now - self._last > self._timeout:
            return None
        positions = np.where(np.isnan(self._positions), effectors, self._positions)
        return Goal(positions, self._stamp, self._fresh)

    def judge(self, effector: int, payload: bytes, encoding: str) -> Received | Fault:
        """Decode a target and check what does not depend on the others."""
        point = decode_point(payload, encoding)
        if isinstance(point, Fault):
            return point
        if point.frame not in ("", self._frame):
            detail = f"found frame {point.frame[:40]!r}, expected {self._frame!r}"
            return Fault(Reason.WRONG_FRAME, detail)
        distance = math.dist(point.xyz, self._rest[effector])
        if not distance <= self._reach:
            detail = f"{distance:.3g} m from the effector at rest, allowed are {self._reach:.3g} m"
            return Fault(Reason.OUT_OF_REACH, detail)
        return Received(effector, payload, encoding, point)


def reach_of(size: float) -> float:
    """Distance from rest beyond which a target is a mistake, a wrong unit for instance [m].

    Args:
        size: diagonal of the robot's bounding box [m].

    A tip cannot leave the ball of its body's length around the base; twice that leaves room for
    targets that are only nearly reachable, which the controller approaches as far as it can.
    """
    return 2.0 * size
