"""Waypoints: set, played at a steady speed, and written as the CSV that `tauten stream` reads."""

from __future__ import annotations

import csv
import io

import numpy as np

from tauten.model.numerics import Array
from tauten.service.plant import TargetPath

MOST = 200  # waypoints


class WaypointList:
    """Positions of one effector, one after another."""

    def __init__(self) -> None:
        """Start without any."""
        self._points: list[Array] = []

    def __len__(self) -> int:
        return len(self._points)

    def add(self, position: Array) -> bool:
        """Add a position (3,) [m]; False where there are as many as allowed."""
        if len(self._points) >= MOST:
            return False
        self._points.append(position.copy())
        return True

    def clear(self) -> None:
        """Forget all."""
        self._points.clear()

    def replace(self, points: Array) -> None:
        """Take positions (m, 3) [m] instead."""
        self._points = [point.copy() for point in points[:MOST]]

    @property
    def points(self) -> Array:
        """(m, 3) [m]."""
        return np.array(self._points).reshape(-1, 3)

    def path(self, start: Array, speed: float) -> TargetPath:
        """From a position through all waypoints at a steady speed.

        Args:
            start: (3,) [m].
            speed: [m/s].
        """
        points = np.vstack([start, self.points])  # (m + 1, 3)
        lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
        return TargetPath(np.concatenate([[0.0], np.cumsum(lengths) / speed]), points, False)

    def csv(self, speed: float) -> str:
        """Columns t [s], x, y, z [m]; t at a steady speed [m/s] from the first waypoint."""
        points = self.points
        lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
        times = np.concatenate([[0.0], np.cumsum(lengths) / speed])[: len(points)]
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(["t", "x", "y", "z"])
        for time, (x, y, z) in zip(times.tolist(), points.tolist(), strict=True):
            writer.writerow([repr(value) for value in (time, x, y, z)])
        return text.getvalue()
