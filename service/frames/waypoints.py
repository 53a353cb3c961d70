"""Waypoints: set, played at a steady speed, and written as the CSV that `tauten stream` reads."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from tauten.model.numerics import Array
from tauten.service.frames.targets import scalar_scale
from tauten.service.plant import (
    PathError,
    TargetPath,
    csv_text_path,
    path_text,
    without_sign_changes,
)
from tauten.service.wire import DescribedEffector

MOST = 200  # waypoints
_LEAST_STEP = 1e-3  # s between waypoints at the same place


class WaypointList:
    """Targets of one effector, one after another."""

    def __init__(self, effector: DescribedEffector, size: float) -> None:
        self._effector, self._size = effector, size
        self._values: list[Array] = []

    def __len__(self) -> int:
        return len(self._values)

    def add(self, values: Array) -> bool:
        """Add goal values (v,); False where there are as many as allowed."""
        if len(self._values) >= MOST:
            return False
        self._values.append(values.copy())
        return True

    def clear(self) -> None:
        """Forget all."""
        self._values.clear()

    def remove(self, number: int) -> None:
        """Forget one, by its number from 0; nothing where there is none."""
        if 0 <= number < len(self._values):
            del self._values[number]

    def move(self, number: int, by: int) -> int:
        """Exchange one, by its number from 0, with the one that is `by` later; returns where it is then."""
        other = number + by
        if not (0 <= number < len(self._values) and 0 <= other < len(self._values)):
            return number
        values = self._values
        values[number], values[other] = values[other], values[number]
        return other

    def load(self, text: str, name: str) -> None:
        """Take those of a CSV file instead, without its times.

        Raises:
            PathError: what is wrong, with the line.
        """
        path = csv_text_path(text, name, self._effector.kind, 1.0, repeats=False)
        if len(path.values) > MOST:
            raise PathError(f"{name}: found {len(path.values)} points, allowed are {MOST}")
        self._values = list(path.values)

    def names(self) -> tuple[str, ...]:
        """One line each, to choose from: its number, and where it is."""
        return tuple(f"{i}: {self._place(one)}" for i, one in enumerate(self._values, 1))

    def _place(self, values: Array) -> str:
        if self._effector.has_position:
            return ", ".join(f"{1e3 * one:.1f}" for one in values[:3]) + " mm"
        scale = scalar_scale(self._effector, self._size)
        return f"{values[0] / scale.one:.1f} {scale.unit}"

    @property
    def points(self) -> Array:
        """Positions (m, 3) [m]; none for effectors without one."""
        if not self._effector.has_position:
            return np.zeros((0, 3))
        return np.array([values[:3] for values in self._values]).reshape(-1, 3)

    def path(self, start: Array, speed: float) -> TargetPath:
        """From a target through all waypoints at a steady speed [m/s]."""
        return self._steady([start, *self._values], speed)

    def straight(self, start: Array, number: int, speed: float) -> TargetPath:
        """From a target straight to one waypoint at a steady speed.

        Args:
            start: (v,) goal values.
            number: of the waypoint, from 0.
            speed: [m/s].
        """
        return self._steady([start, self._values[number]], speed)

    def csv(self, speed: float) -> str:
        """Columns t [s] and those of the effector's kind, at a steady speed [m/s]."""
        return path_text(self._steady(self._values, speed))

    def _steady(self, values: list[Array], speed: float) -> TargetPath:
        """Goal values at a steady speed [m/s]; quaternions without changes of sign."""
        table = np.array(values).reshape(-1, len(self._effector.rest))
        if self._effector.turns:
            table[:, 3:] = without_sign_changes(table[:, 3:])
        lengths = np.array([self._length(*pair) for pair in pairwise(table)])
        steps = np.maximum(lengths / speed, _LEAST_STEP)
        times = np.concatenate([[0.0], np.cumsum(steps)])[: len(table)]
        return TargetPath(times, table, False, self._effector.kind)

    def _length(self, start: Array, end: Array) -> float:
        """Way between two targets (v,) [m]."""
        if self._effector.kind == "volume":
            return float(abs(end[0] - start[0]) / np.cbrt(self._effector.rest[0]) ** 2)
        way = float(np.linalg.norm((end - start)[:3]))
        if self._effector.turns:
            half = min(abs(float(start[3:] @ end[3:])), 1.0)
            way = max(way, self._size * 2.0 * float(np.arccos(half)))
        return way
