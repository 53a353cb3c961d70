"""Outer forces on points of a body."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from tauten.model.numerics import Array
from tauten.model.points.entries import Entries, Motion

P = TypeVar("P")


@dataclass(frozen=True, slots=True)
class OuterForces(Generic[P]):
    """Forces of fixed direction on points of type P.

    Attributes:
        points: the points.
        vectors: (p, 3) [N].
    """

    points: P
    vectors: Array

    def __bool__(self) -> bool:
        return bool(self.vectors.any())

    def on(self, motion: Motion[P]) -> Array:
        """Forces (n,) on the unknowns of a body [N]."""
        count = len(self.vectors)
        entries = Entries(np.array([0, count]), np.arange(count), self.vectors)
        force: Array = motion.placed(self.points).rows(entries).T @ np.ones(1)
        return force

    def work(self, motion: Motion[P], rest: Motion[P]) -> float:
        """Work of the forces on the way from one state to another [J]."""
        moved = motion.placed(self.points).y - rest.placed(self.points).y
        return float(np.vdot(self.vectors, moved))
