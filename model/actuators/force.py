"""Forces of fixed direction: δ is the displacement of a point along it, or the mean one of several points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tauten.model.numerics import Array, Ints
from tauten.model.points import Entries, Placed
from tauten.model.rows import Rows


@dataclass(frozen=True, slots=True)
class ForceSet:
    """All forces of a robot, each shared out to points of its own.

    Attributes:
        directions: (f, 3) unit vectors.
        starts: (f + 1,) where the points of each force start among all of them.
        shares: (p,) of the force on each point; those of a force sum to one.
        rest: (f,) mean positions of the points along the directions at rest [m].
    """

    directions: Array
    starts: Ints
    shares: Array
    rest: Array

    def __len__(self) -> int:
        return len(self.directions)

    def means(self, y: Array) -> Array:
        """Mean positions (f, 3) of the points y (p, 3) of each force [m]."""
        found: Array = np.add.reduceat(self.shares[:, None] * y, self.starts[:-1])
        return found

    def segments(self, y: Array) -> Array:
        """The means of points y (p, 3) of the forces, and one metre along them: (f, 2, 3) [m]."""
        mean = self.means(y)
        return np.stack([mean, mean + self.directions], axis=1)

    def vectors(self, efforts: Array) -> Array:
        """The forces (p, 3) on all points of efforts (f,) [N]."""
        spread = np.repeat(efforts[:, None] * self.directions, np.diff(self.starts), axis=0)
        found: Array = self.shares[:, None] * spread
        return found

    def rows(self, placed: Placed) -> Rows:
        """Mean displacements along the directions: Rows of (f, n) [m]."""
        along = self.vectors(np.ones(len(self)))
        H = placed.rows(Entries(self.starts, np.arange(len(along)), along))
        delta = np.einsum("fi,fi->f", self.directions, self.means(placed.y)) - self.rest
        return Rows(H, delta)


def make_forces(directions: Array, shares: Sequence[Array], y0: Array) -> ForceSet:
    """Forces on points.

    Args:
        directions: (f, 3) unit vectors.
        shares: of each force on its points; they sum to one.
        y0: (p, 3) the points of all forces at rest [m].
    """
    starts = np.cumsum([0, *(len(part) for part in shares)])
    every = np.concatenate([np.zeros(0), *shares])
    still = ForceSet(directions, starts, every, np.zeros(len(directions)))
    return ForceSet(directions, starts, every, np.einsum("fi,fi->f", directions, still.means(y0)))
