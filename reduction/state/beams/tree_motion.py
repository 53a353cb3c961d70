"""A tree of beams at one state: where its points are, and how they move with its natural strains."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model import ChainedRows
from tauten.model.numerics import Array, Ints
from tauten.model.points import AttachedPoints, Entries, Placed, PlacedOnBeams, dense_units
from tauten.reduction.state.beams.motion import point_rows


@dataclass(frozen=True, slots=True, eq=False)
class TreeMotion:
    """A tree of beams at one state, a `Motion` of `AttachedPoints`; its natural strains are the unknowns.

    Attributes:
        x: (n_nodes, 3) positions [m].
        Q: (n_nodes, 4) rotations.
        J: (6 n_nodes, r) their derivatives.
    """

    x: Array
    Q: Array
    J: Array

    travel = np.zeros(0)  # motors move no unknown directly

    @property
    def n(self) -> int:
        """Unknowns."""
        return int(self.J.shape[1])

    def placed(self, points: AttachedPoints) -> PlacedOnTree:
        """Points of the body at this state."""
        return PlacedOnTree(*points.place(self.x, self.Q), points, self.J)

    def units(self, columns: Ints) -> Array:
        """Unit rows (m, n) of some unknowns (m,)."""
        return dense_units(columns, self.n)


@dataclass(frozen=True, slots=True, eq=False)
class PlacedOnTree(Placed):
    """Attached points at one state of beams whose natural strains are the unknowns.

    Attributes, beside those of all placed points:
        arms: (p, 2, 3) weighted lever arms [m].
        points: the points.
        J: (6 n_nodes, r) motion of the nodes.
    """

    arms: Array
    points: AttachedPoints
    J: Array

    def rows(self, entries: Entries) -> Array:
        """Rows (m, r) over the unknowns, of rows over these points."""
        found: Array = point_rows(
            entries.starts, entries.points, entries.vectors,
            self.points.nodes, self.points.weights, self.arms, self.J,
        )  # fmt: skip
        return found

    def many_rows(self, entries: Entries, delta: Array) -> ChainedRows:
        """Rows over the nodes, with the motion of these by the unknowns."""
        nodes = len(self.J) // 6
        S = PlacedOnBeams(self.y, self.arms, self.points, 6 * np.arange(nodes), 6 * nodes)
        H = S.rows(entries)
        return ChainedRows(H.indptr, H.indices, H.data, self.J, delta)
