"""Targets of the effectors: what the operator drags, clamped to reach, followed only while armed."""

from __future__ import annotations

import threading

import numpy as np

from tauten.model.numerics import Array
from tauten.service.wire import reach_of

_FAR = 1e6  # m; squares of larger numbers may overflow
_WITHIN = 0.999  # of the reach, so that rounding on the wire cannot put a target outside


class TargetStore:
    """The newest targets, written by callbacks of the browser and read by the loop.

    A dead man's switch: there are targets only while *follow* is armed, and it is disarmed when the
    browser leaves. Before it is armed the targets are where the effectors are, so that arming never makes a
    robot jump.
    """

    def __init__(self, rest: Array, size: float) -> None:
        """Start disarmed.

        Args:
            rest: (p, 3) of the effectors [m].
            size: diagonal of the robot's bounding box [m].
        """
        self._rest = rest.copy()
        self._reach = _WITHIN * reach_of(size)
        self._positions = rest.copy()
        self._armed = False
        self._lock = threading.Lock()

    @property
    def armed(self) -> bool:
        """Whether the robot follows."""
        return self._armed

    def arm(self, armed: bool) -> None:
        """Follow the targets, or stop to."""
        with self._lock:
            self._armed = armed

    def put(self, effector: int, position: tuple[float, ...] | Array) -> None:
        """Move a target, to the nearest position within reach; without effect while disarmed.

        Args:
            effector: number.
            position: (3,) [m].
        """
        found = self.clamped(effector, np.asarray(position, dtype=float))
        with self._lock:
            if self._armed and found is not None:
                self._positions[effector] = found

    def clamped(self, effector: int, position: Array) -> Array | None:
        """The nearest position within reach; None for what is no position.

        Args:
            effector: number.
            position: (3,) [m].
        """
        if position.shape != (3,) or not np.isfinite(position).all():
            return None
        away = np.clip(position - self._rest[effector], -_FAR, _FAR)
        distance = float(np.linalg.norm(away))
        if distance <= self._reach:
            return position.copy()
        nearest: Array = self._rest[effector] + away * (self._reach / distance)
        return nearest

    def rest_at(self, effectors: Array) -> None:
        """While disarmed: the targets are where the effectors (p, 3) [m] are."""
        with self._lock:
            if not self._armed and np.isfinite(effectors).all():
                self._positions = effectors.copy()

    def goal(self) -> Array | None:
        """Positions (p, 3) [m] to follow; None while disarmed."""
        with self._lock:
            return self._positions.copy() if self._armed else None

    @property
    def positions(self) -> Array:
        """(p, 3) [m], also while disarmed."""
        with self._lock:
            return self._positions.copy()
