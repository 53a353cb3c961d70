"""Drives and drums: actuators that move a coordinate of the robot directly, by a unit row."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tauten.model.numerics import Array, Bools, Ints
from tauten.model.points import Motion
from tauten.model.rows import Rows, stack


@dataclass(frozen=True, slots=True)
class DriveSet:
    """All drives of a robot, then its drums.

    Attributes:
        places: (m,) their numbers among all single actuators.
        columns: (m,) the unknown that each moves.
        travels: (m,) the number of its coordinate in `Motion.travel`.
        axes: (s, 3) unit directions of those that are drawn, the first ones.
        beside: (s, 3) the point of each axis beside what it moves, at rest [m].
        slides: (s,) whether it moves along its axis, instead of turning about it.
    """

    places: Ints
    columns: Ints
    travels: Ints
    axes: Array
    beside: Array
    slides: Bools

    def __len__(self) -> int:
        return len(self.places)

    def others(self, count: int) -> Ints:
        """Numbers of what is no drive among all single actuators, of which there are `count`."""
        free = np.ones(count, np.bool_)
        free[self.places] = False
        return np.flatnonzero(free)

    def among(self, others: Rows, motion: Motion[Any]) -> Rows:
        """Rows of all single actuators, from those that are no drives."""
        units = Rows(motion.units(self.columns), motion.travel[self.travels])
        count = len(others) + len(self)
        order = np.empty(count, dtype=np.int64)
        order[self.places] = len(others) + np.arange(len(self))
        order[self.others(count)] = np.arange(len(others))
        return stack([others, units]).in_order(order)

    def segments(self, travel: Array) -> Array:
        """The axis of each that is drawn, a point and one metre along, at travel (d,): (s, 2, 3) [m]."""
        moved = np.where(self.slides, travel[self.travels[: len(self.axes)]], 0.0)
        points = self.beside + moved[:, None] * self.axes
        return np.stack([points, points + self.axes], axis=1)


def no_drives() -> DriveSet:
    """No drives and no drums."""
    none, nowhere = np.zeros(0, dtype=np.int64), np.zeros((0, 3))
    return DriveSet(none, none, none, nowhere, nowhere, np.zeros(0, dtype=bool))
