"""Targets of the effectors: what the operator sets, clamped to reach, followed only while armed."""

from __future__ import annotations

import threading
from dataclasses import dataclass

import numpy as np

from tauten.model.numerics import Array
from tauten.service.wire import DescribedEffector, places_of, reach_of

_FAR = 1e6  # m; squares of larger numbers may overflow
_WITHIN = 0.999  # of the reach, so that rounding on the wire cannot put a target outside
LEAST_SCALAR, LARGEST_SCALAR = 0.5, 2.0  # times the value at rest: distances, lengths, volumes


@dataclass(frozen=True, slots=True)
class ScalarScale:
    """How targets of one number are shown.

    Attributes:
        unit: what they are shown in.
        one: goal value that is one of these.
        least: smallest target in this unit.
        largest: largest one.
    """

    unit: str
    one: float
    least: float
    largest: float


def scalar_scale(effector: DescribedEffector, size: float) -> ScalarScale:
    """Percent of the value at rest; millimetres of functions, which may be zero there, or negative.

    Functions go as far as the robot is large [m].
    """
    (rest,) = effector.rest
    if effector.kind == "function":
        return ScalarScale("mm", 1e-3, 1e3 * (rest - size), 1e3 * (rest + size))
    return ScalarScale("%", 0.01 * rest, 100.0 * LEAST_SCALAR, 100.0 * LARGEST_SCALAR)


class TargetStore:
    """The newest targets as goal values, written by callbacks of the browser and read by the loop.

    A dead man's switch: there are targets only while *follow* is armed, and it is disarmed when the
    browser leaves. Before it is armed the targets are where the effectors are, so that arming never makes a
    robot jump.

    Attributes:
        armed: whether the robot follows.
    """

    def __init__(self, effectors: tuple[DescribedEffector, ...], size: float) -> None:
        self._effectors, self._places = effectors, places_of(effectors)
        self._size, self._reach = size, _WITHIN * reach_of(size)
        self._values = np.concatenate([np.array(one.rest) for one in effectors])
        self.armed = False
        self._lock = threading.Lock()

    def arm(self, armed: bool) -> None:
        """Follow the targets, or stop to."""
        with self._lock:
            self.armed = armed

    def put(self, effector: int, values: tuple[float, ...] | Array) -> None:
        """Move a target, to the nearest values within reach; without effect while disarmed.

        These are goal values (v,) of an effector, or its position (3,) alone.
        """
        found = self.clamped(effector, np.asarray(values, dtype=float))
        with self._lock:
            if self.armed and found is not None:
                first = self._places[effector].start
                self._values[first : first + len(found)] = found

    def clamped(self, effector: int, values: Array) -> Array | None:
        """The nearest values within reach; None for what is no target of this effector."""
        one = self._effectors[effector]
        if not np.isfinite(values).all():
            return None
        if not one.has_position:
            scale = scalar_scale(one, self._size)
            low, high = scale.one * scale.least, scale.one * scale.largest
            return np.clip(values, low, high) if values.shape == (1,) else None
        if values.shape not in ((3,), (len(one.rest),)):
            return None
        rest = np.array(one.rest[:3])
        away = np.clip(values[:3] - rest, -_FAR, _FAR)
        distance = float(np.linalg.norm(away))
        found = values.copy()
        if distance > self._reach:
            found[:3] = rest + away * (self._reach / distance)
        if len(values) == 3:
            return found
        length = float(np.linalg.norm(np.clip(values[3:], -_FAR, _FAR)))
        if length < 1e-3:  # no rotation
            return found[:3]
        found[3:] = np.clip(values[3:], -_FAR, _FAR) / length
        return found

    def rest_at(self, values: Array) -> None:
        """While disarmed: the targets are where the effectors, goal values (n_v,), are."""
        with self._lock:
            if not self.armed and np.isfinite(values).all():
                self._values = values.copy()

    def goal(self) -> Array | None:
        """Goal values (n_v,) to follow; None while disarmed."""
        with self._lock:
            return self._values.copy() if self.armed else None

    @property
    def values(self) -> Array:
        """Goal values (n_v,), also while disarmed."""
        with self._lock:
            return self._values.copy()

    def of(self, effector: int) -> Array:
        """Goal values (v,) of one effector."""
        return self.values[self._places[effector]]
