"""The last clamp: nothing outside the robot's limits leaves the node, whatever was decided."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tauten.model import Limits
from tauten.model.numerics import Array, kernel

# Changes below this fraction of a cable's range are rounding of a solver, not worth a report.
ROUNDING = 1e-6


@dataclass(frozen=True, slots=True)
class LimitedActuation:
    """Values that may leave.

    Attributes:
        pull: (n_a,) pulled lengths [m].
        tension: (n_a,) tensions [N].
        clamped: whether a limit changed them by more than rounding.
    """

    pull: Array
    tension: Array
    clamped: bool


class ActuationLimiter:
    """Clamps pulled lengths and tensions to a robot's limits; the rate is per control period.

    The winches are taken to be at rest, pull 0, when the guard is made.

    Attributes:
        last: what left last.
    """

    def __init__(self, limits: Limits, h: float) -> None:
        """ActuationLimiter a robot.

        Args:
            limits: of its cables.
            h: control period [s].
        """
        self._limits = limits
        self._h = h
        self._step = limits.rate * h  # (n_a,) m
        self._rounding_pull = ROUNDING * (limits.pull_max - limits.pull_min)
        self._rounding_tension = ROUNDING * limits.tension_max
        self.last = self.rest()

    def rest(self) -> LimitedActuation:
        """Nothing pulled: pull 0 and the least tension, as far as the limits allow."""
        zero = np.zeros(len(self._step))
        limits = self._limits
        return LimitedActuation(
            np.clip(zero, limits.pull_min, limits.pull_max),
            np.clip(zero, limits.tension_min, limits.tension_max),
            False,
        )

    def __call__(self, pull: Array, tension: Array) -> LimitedActuation:
        """Clamp what is about to leave.

        Args:
            pull: (n_a,) pulled lengths [m].
            tension: (n_a,) tensions [N].

        Returns:
            The clamped values; those that left last when any value is not finite or the
            shapes are wrong.
        """
        shape, last = self._step.shape, self.last
        pull, tension = np.asarray(pull, dtype=float), np.asarray(tension, dtype=float)
        if not (pull.shape == shape == tension.shape and _finite(pull) and _finite(tension)):
            self.last = LimitedActuation(last.pull, last.tension, True)
            return self.last
        limits = self._limits
        lower, upper = _reachable(last.pull, self._step, limits.pull_min, limits.pull_max)
        safe_pull, turned = _clamped(pull, lower, upper, self._rounding_pull)
        safe_tension, eased = _clamped(
            tension, limits.tension_min, limits.tension_max, self._rounding_tension
        )
        self.last = LimitedActuation(safe_pull, safe_tension, turned or eased)
        return self.last

    def release(self, release_time: float) -> Iterator[LimitedActuation]:
        """Values that let the cables go, period by period, in a straight ramp from those that left last.

        Args:
            release_time: seconds it takes at least; longer where the rate asks for it.
        """
        start, rest = self.last, self.rest()
        way = np.abs(start.pull - rest.pull)  # (n_a,) m
        slowest = float((way / self._step).max(initial=0.0))
        steps = max(int(np.ceil(release_time / self._h)), int(np.ceil(slowest)), 1)
        for step in range(1, steps + 1):
            left = 1.0 - step / steps
            yield self(
                rest.pull + left * (start.pull - rest.pull),
                rest.tension + left * (start.tension - rest.tension),
            )


@kernel
def _finite(values: Array) -> bool:
    """Whether all numbers (n_a,) are."""
    # not np.isfinite: where sums may be reordered LLVM takes its x - x for zero
    return bool(np.sum((values > -np.inf) & (values < np.inf)) == values.shape[0])


@kernel
def _reachable(last: Array, step: Array, least: Array, most: Array) -> tuple[Array, Array]:
    """Pulled lengths a winch can be at one period later: lower and upper (n_a,) [m]."""
    return np.maximum(least, last - step), np.minimum(most, last + step)


@kernel
def _clamped(value: Array, lower: Array, upper: Array, rounding: Array) -> tuple[Array, bool]:
    """Values (n_a,) within bounds, and whether one changed by more than rounding."""
    safe = np.empty_like(value)
    changed = False
    for i in range(value.shape[0]):
        safe[i] = min(max(value[i], lower[i]), upper[i])
        changed = changed or abs(safe[i] - value[i]) > rounding[i]
    return safe, changed
