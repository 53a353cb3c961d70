"""Plausibility of measurements: could the robot that the model describes be where it is measured?

| check | a measurement is refused when | for instance |
|---|---|---|
| distance | it is farther than a quarter of the robot's size from the model | wrong unit or frame |
| exchange | two effectors are closer to each other's model than to their own | exchanged markers |
| rate | the difference of robot and model changes faster than any robot does | a wrong marker |
| progress | the model moves and the measurement does not, twice in a row | frozen, mirrored, turned |

The first three concern one measurement; the next one may be plausible again. Progress is the part of the
model's displacement Δx_e that the measurement has made too, ⟨Δx_m, Δx_e⟩ / ⟨Δx_e, Δx_e⟩, over all effectors
together in metres, computed whenever the model has moved by a part of the robot's size, over at least a
tenth of a second: a robot that has just begun to move is behind its model. It is 1 for a robot like its
model, 0 for a frozen measurement or one turned by 90°, −1 for a mirrored one. A node that holds measures no
motion and cannot find out that the fault is gone, so this fault is kept until `reset`.
"""

from __future__ import annotations

from collections import deque

import numpy as np

from tauten.model import EffectorLayout
from tauten.model.numerics import Array

_MOVED = 0.04  # of the robot's size, motion of the model after which progress is looked at
_LASTING = 0.1  # s, time over which progress is looked at, at least
_PROGRESS = 0.1  # least part of the model's motion that a measurement must have made
_IN_A_ROW = 2  # times without progress
_RATE = 2.0  # robot sizes a second by which the difference of robot and model may change
_JUMP = 0.05  # of the robot's size, and by which it may change at once
# of the robot's size, distance from the model within which an exchange does not matter
_CLOSE = 0.02
_CLOSER = 0.5  # part of its own distance at which an exchanged effector is clearly another
_SWING = 0.03  # of the robot's size, by which a robot swings about its model that health warns of
_SWUNG = 2.0  # s, over which this is looked at
_EVEN = 0.1  # s, over which measurements are averaged there
_MOST = 2000  # measurements of that time that are kept at most
_WAYS = 6.0  # how often it goes this far, there or back, within that time


class MeasurementCheck:
    """Compares measurements with the model.

    Attributes:
        fault: why measurements are not used until `reset`; "" while they are.
    """

    def __init__(self, layout: EffectorLayout, size: float, largest: float) -> None:
        """Start without a measurement.

        Args:
            layout: of the effectors; rotations, lengths and volumes count in metres by its units.
            size: of the robot [m].
            largest: plausible distance of a measured effector from the model [m].
        """
        self._layout = layout
        self._size = size
        self._largest = largest
        self.fault = ""
        self.reset()

    def reset(self) -> None:
        """Remove all measurements and the fault."""
        self.fault = ""
        self._difference: Array | None = None  # (n_e,) of the last plausible measurement and model
        self._start: tuple[Array, Array] | None = None  # model and measurement where motion began
        self._lasted = 0.0  # time since then [s]
        self._still = 0  # times without progress in a row

    def reason(self, model: Array, measured: Array, seconds: float) -> str:
        """Why a measurement is not plausible; "" where it is.

        Args:
            model: (n_v,) the model's effectors when it was made.
            measured: (n_v,) the measured effectors.
            seconds: since the plausible measurement before.
        """
        if self.fault:
            return self.fault
        layout = self._layout
        difference = layout.difference(measured, model)  # (n_e,)
        distance = layout.lengths(difference)
        farthest = float(distance.max())
        if not farthest <= self._largest:
            return (
                f"an effector is measured {1e3 * farthest:.3g} mm from the model, "
                f"allowed are {1e3 * self._largest:.3g} mm"
            )
        places = [layout.position_values(values) for values in (model, measured)]
        several = len(places[0]) > 1 and farthest > _CLOSE * self._size
        if several and _exchanged(*places):
            return "two measured effectors are exchanged"
        if self._difference is not None:
            change = float(layout.lengths(difference - self._difference).max())
            allowed = self._size * (_JUMP + _RATE * seconds)
            if change > allowed:
                return (
                    f"the measurement jumps by {1e3 * change:.3g} mm against the model, "
                    f"allowed are {1e3 * allowed:.3g} mm"
                )
        self._difference = difference
        self._lasted += seconds
        self._look_at_progress(model, measured)
        return self.fault

    def _look_at_progress(self, model: Array, measured: Array) -> None:
        if self._start is None:
            self._start, self._lasted = (model, measured), 0.0
            return
        if self._lasted < _LASTING:
            return
        layout = self._layout
        moved, seen = (
            layout.units * layout.difference(now, start)
            for now, start in zip((model, measured), self._start, strict=True)
        )  # (n_e,)
        squared = float(np.vdot(moved, moved))
        if squared < (_MOVED * self._size) ** 2:
            return
        progress = float(np.vdot(seen, moved)) / squared
        self._start, self._lasted = (model, measured), 0.0
        self._still = self._still + 1 if progress < _PROGRESS else 0
        if self._still >= _IN_A_ROW:
            self.fault = (
                f"the model moves and the measurement does not follow it ({progress:.2g} of its motion): "
                "is it frozen, mirrored or turned, or does the robot swing? then send enable"
            )


class Swing:
    """Whether a robot swings about its model, as one does whose damping is too light for the gain.

    The way of what is measured from the model is then many times as long as its extent, which it is not where
    that differs evenly, or as targets change that go round at 0.5 Hz.
    """

    def __init__(self, layout: EffectorLayout, size: float) -> None:
        """Start without a measurement.

        Args:
            layout: of the effectors; rotations, lengths and volumes count in metres by its units.
            size: of the robot [m].
        """
        self._layout, self._least = layout, _SWING * size
        self._past: deque[tuple[float, Array]] = deque(maxlen=_MOST)

    def add(self, now: float, model: Array, measured: Array) -> None:
        """Keep a difference.

        Args:
            now: monotonic time [s].
            model: (n_v,) the model's effectors when it was measured.
            measured: (n_v,) the measured effectors.
        """
        past = self._past
        past.append((now, self._layout.units * self._layout.difference(measured, model)))
        while past[0][0] < now - _SWUNG:
            past.popleft()

    @property
    def extent(self) -> float:
        """From one side to the other [m]; 0 where it does not swing."""
        if len(self._past) < 2:
            return 0.0
        past = self._past
        seen = np.cumsum([np.zeros_like(past[0][1]), *(one for _, one in past)], axis=0)
        lasted = past[-1][0] - past[0][0]  # s
        several = max(1, round(_EVEN * len(past) / lasted)) if lasted > _EVEN else 1
        differences = (seen[several:] - seen[:-several]) / several  # (k, n_e), without noise
        way = float(np.linalg.norm(np.diff(differences, axis=0), axis=1).sum())
        extent = float(np.linalg.norm(np.ptp(differences, axis=0)))
        return extent if extent > self._least and way > _WAYS * extent else 0.0

    def reset(self) -> None:
        """Remove all measurements."""
        self._past.clear()


def _exchanged(model: Array, measured: Array) -> bool:
    """Whether two positions (m, 3) are clearly closer to each other's model than to their own."""
    distance = np.linalg.norm(measured - model, axis=1)  # (m,)
    across = np.sqrt(np.sum((measured[:, None] - model[None]) ** 2, axis=2))  # (p, p)
    return bool(np.any(across + across.T < _CLOSER * (distance[:, None] + distance[None])))
