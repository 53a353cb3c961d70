"""Closed loop: the measured effectors correct the target by integral action on top of the model.

Differences and corrections are those of `EffectorLayout`: rotations about the frame's own axes.

With target x_t, measurement x_m, the model's effector x_e and the goal x_g = x_t + c of the model, the
correction c obeys

    dc/dt = g ((x_t − x_m) + (x_e − x_g)) = g (x_e − x_m − c).

The first term integrates the tracking error. The second is the anti-windup by back-calculation (Åström
and Hägglund, PID Controllers, 1995, section 3.5): what the model cannot reach, because of a limit or a
contact, is taken back. So c never grows beyond the distance of model and robot, whatever the target, and in
equilibrium x_m = x_t where the model reaches its goal.

A measurement that is d seconds old is compared with the model of d seconds ago. Where the delay is not the
stated one the loop acts as an integrator with a delay, which is stable for g d < π / 2 (the phase of
g exp(−s d) / s reaches −180° where its magnitude is one); `stable_gain` keeps half of that.

A robot that swings at an angular frequency ω with a damping ratio ζ, longer than its model, goes on for
ever where g > 2 ζ ω: its correction is late by a quarter of the period, and pushes it where it goes. So
differences of model and robot are averaged over a time T, the period of the model's slowest vibration. Then
that is so where g sin(ω T) / ω T > 2 ζ ω: nowhere between half of the model's frequency, as with a payload,
and all of it, and above it with eight times the gain at least. To all else the mean is late by T / 2.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from itertools import islice
from math import pi

import numpy as np

from tauten.model import EffectorLayout
from tauten.model.numerics import Array

# A model that is farther off than this part of the robot's size is wrong, not inexact.
LARGEST = 0.25
_MARGIN = 0.5  # part of the largest stable gain that is used
_ROUNDING = 1e-9  # s
_LONGEST = 8192  # positions of the model kept at most


def stable_gain(gain: float, delay: float) -> float:
    """The gain [1/s] that is used in place of g [1/s] where measurements have a delay d [s].

    It is at most half of π / (2 d), where an integrator with that delay becomes unstable.
    """
    return gain if delay <= 0.0 else min(gain, _MARGIN * pi / (2.0 * delay))


def capped(layout: EffectorLayout, correction: Array, largest: float) -> Array:
    """A correction (n_e,) of which no position, rotation or scalar is longer than allowed.

    Args:
        layout: of the effectors.
        correction: (n_e,).
        largest: length, in metres by the layout's units [m].
    """
    found = correction.copy()
    for part, length in zip(layout.parts(), layout.lengths(correction), strict=True):
        found[part] *= min(1.0, largest / max(length, 1e-300))
    return found


class Feedback:
    """Integral correction of targets.

    Attributes:
        correction: (n_e,) added to the targets.
        gain: g that is used [1/s].
        largest: no correction of a position, rotation or scalar is longer, in metres [m].
    """

    def __init__(
        self,
        layout: EffectorLayout,
        gain: float,
        largest: float,
        delay: float = 0.0,
        average: float = 0.0,
    ) -> None:
        """Start without correction.

        Args:
            layout: of the effectors.
            gain: g [1/s].
            largest: no correction is longer, in metres by the layout's units [m].
            delay: of the measurements [s]; see `stable_gain`.
            average: T, over which differences are averaged [s]; 0: the last one counts.
        """
        self.gain = stable_gain(gain, delay + 0.5 * average)
        self.largest = largest
        self._layout = layout
        self._average = average
        self.correction: Array = np.zeros(layout.n_rows)
        self._past: deque[tuple[float, Array]] = deque()  # times [s] and differences (n_e,)
        self._lasted = 0.0  # their sum [s]
        self._sum = self.correction.copy()  # (n_e,) of the products of both

    def update(self, predicted: Array, measured: Array, seconds: float) -> Array:
        """The correction (n_e,) after a measurement, see `Estimator`."""
        if not np.isfinite(predicted).all():
            return self.correction
        # exact for constant x_e - x_m, so that no gain and no pause makes it overshoot
        share = 1.0 - np.exp(-self.gain * seconds)
        layout = self._layout
        difference = self._mean(seconds, layout.difference(predicted, measured))  # (n_e,)
        correction = self.correction + share * (difference - self.correction)  # (n_e,)
        self.correction = capped(layout, correction, self.largest)
        return self.correction

    def _mean(self, seconds: float, difference: Array) -> Array:
        """The mean difference (n_e,) of the time that is averaged over, with one that counts for some [s]."""
        past = self._past
        past.append((seconds, difference))
        self._lasted += seconds
        self._sum += seconds * difference
        while len(past) > 1 and self._lasted - past[0][0] > self._average - _ROUNDING:
            time, one = past.popleft()
            self._lasted -= time
            self._sum -= time * one
        if len(past) == 1 or self._lasted <= 0.0:
            return difference
        mean: Array = self._sum / self._lasted
        return mean

    def reset(self) -> None:
        """No correction."""
        self.correction = np.zeros_like(self.correction)
        self._past.clear()
        self._lasted, self._sum = 0.0, np.zeros_like(self.correction)


class ModelHistory:
    """The model's effectors of the last moments, for measurements that are late."""

    def __init__(self, layout: EffectorLayout) -> None:
        self._layout = layout
        self._past: deque[tuple[float, Array]] = deque(maxlen=_LONGEST)

    def add(self, now: float, effectors: Array) -> None:
        """Keep the model's effectors (n_v,) of a time [s]."""
        self._past.append((now, effectors.copy()))

    def at(self, times: Sequence[float]) -> Array:
        """The values (n_v,) of each effector at a time of its own [s]; those from before all are forgotten.

        Between two ticks the model moves evenly.
        """
        past, first = self._past, min(times)
        while len(past) > 1 and past[1][0] <= first:
            past.popleft()
        found = np.empty_like(past[0][1])
        for effector, wanted in enumerate(times):
            part = self._layout.values_of(effector)
            found[part] = self._between(wanted)[part]
        return found

    def _between(self, wanted: float) -> Array:
        """The values (n_v,) of all effectors at a time [s]."""
        start, values = self._past[0]
        for end, after in islice(self._past, 1, None):
            if end > wanted:
                share = max((wanted - start) / (end - start), 0.0)
                return self._layout.moved(values, share * self._layout.difference(after, values))
            start, values = end, after
        return values
