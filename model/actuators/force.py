"""Forces of fixed direction: δ is the displacement of a point along it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.numerics import Array
from tauten.model.points import Entries, Placed
from tauten.model.rows import Rows


@dataclass(frozen=True, slots=True)
class ForceSet:
    """All forces of a robot, each on one point.

    Attributes:
        directions: (f, 3) unit vectors.
        rest: (f,) positions of the points along them at rest [m].
    """

    directions: Array
    rest: Array

    def __len__(self) -> int:
        return len(self.rest)

    def segments(self, y: Array) -> Array:
        """The points y (f, 3) of the forces, and one metre along them: (f, 2, 3) [m]."""
        return np.stack([y, y + self.directions], axis=1)

    def vectors(self, efforts: Array) -> Array:
        """The forces (f, 3) of efforts (f,) [N]."""
        return efforts[:, None] * self.directions

    def rows(self, placed: Placed) -> Rows:
        """Displacements along the directions: Rows of (f, n) [m].

        Args:
            placed: the points.
        """
        count = len(self)
        H = placed.rows(Entries(np.arange(count + 1), np.arange(count), self.directions))
        return Rows(H, np.einsum("fi,fi->f", self.directions, placed.y) - self.rest)


def make_forces(directions: Array, y0: Array) -> ForceSet:
    """Forces on points.

    Args:
        directions: (f, 3) unit vectors.
        y0: (f, 3) the points at rest [m].
    """
    return ForceSet(directions, np.einsum("fi,fi->f", directions, y0))
