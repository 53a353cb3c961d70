"""Clamps tension, pulled length and rate of every decision to the robot's limits before it is published."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tauten.controller import Actuation
from tauten.model import Limits
from tauten.model.numerics import Array, kernel

# Changes below this fraction of a cable's range are rounding of a solver and not reported.
ROUNDING = 1e-6


class ActuationLimiter:
    """Clamps pulled lengths and tensions to a robot's limits; the rate is per control period.

    It has no memory: the controller keeps what left last.

    Attributes:
        rest_position: (n_a,) pulled lengths of slack cables, 0 as far as the limits allow [m].
        rest_effort: (n_a,) least tensions [N].
    """

    def __init__(self, limits: Limits, h: float) -> None:
        """Limit actuations of one robot, with a control period h [s]."""
        self._limits = limits
        self._h = h
        self._step = limits.rate * h  # (n_a,) m
        self._rounding_position = ROUNDING * (limits.position_max - limits.position_min)
        self._rounding_effort = ROUNDING * limits.largest_effort
        zero = np.zeros(len(self._step))
        self.rest_position: Array = np.clip(zero, limits.position_min, limits.position_max)
        self.rest_effort: Array = np.clip(zero, limits.effort_min, limits.effort_max)

    def limit(self, wanted: Actuation, last: Actuation) -> Actuation:
        """Clamp what is about to leave.

        Returns:
            `wanted` with clamped values; with the values of `last` when any value is not finite or the
            shapes are wrong.
        """
        shape, limits = self._step.shape, self._limits
        position = np.asarray(wanted.position, dtype=float)
        effort = np.asarray(wanted.effort, dtype=float)
        if not (position.shape == shape == effort.shape and _finite(position) and _finite(effort)):
            return wanted.with_values(last.position, last.effort, clamped=True)
        lower, upper = _reachable(
            last.position, self._step, limits.position_min, limits.position_max
        )
        safe_position, position_clamped = _clamped(position, lower, upper, self._rounding_position)
        safe_effort, effort_clamped = _clamped(
            effort, limits.effort_min, limits.effort_max, self._rounding_effort
        )
        clamped = wanted.clamped or position_clamped or effort_clamped
        return wanted.with_values(safe_position, safe_effort, clamped)

    def at_rest(self, actuation: Actuation) -> bool:
        """Whether the cables are slack."""
        slack = (actuation.position == self.rest_position) & (actuation.effort == self.rest_effort)
        return bool(slack.all())

    def release(self, start: Actuation, release_time: float) -> Iterator[Actuation]:
        """Actuations that slacken the cables, one a period, in a straight ramp from `start`; then rest.

        The ramp takes `release_time` at least [s], and longer where the rate needs it.
        """
        position = start.position - self.rest_position  # (n_a,)
        effort = start.effort - self.rest_effort  # (n_a,)
        slowest = float((np.abs(position) / self._step).max(initial=0.0))
        steps = max(int(np.ceil(release_time / self._h)), int(np.ceil(slowest)))
        for step in range(1, steps):
            left = 1.0 - step / steps
            yield start.with_values(
                self.rest_position + left * position,
                self.rest_effort + left * effort,
                clamped=False,
            )
        while True:  # again: rounding may leave the last step of the ramp short of rest
            yield start.with_values(self.rest_position, self.rest_effort, clamped=False)


@kernel
def _finite(values: Array) -> bool:
    """Whether all numbers (n_a,) are finite."""
    # not np.isfinite: where sums may be reordered LLVM takes its x - x for zero
    return bool(np.sum((values > -np.inf) & (values < np.inf)) == values.shape[0])


@kernel
def _reachable(last: Array, step: Array, least: Array, most: Array) -> tuple[Array, Array]:
    """Pulled lengths a winch can reach one period later: lower and upper (n_a,) [m]."""
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
