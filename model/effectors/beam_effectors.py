"""Effectors of robots made of beams, over points attached to nodes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.effectors.effector_set import EffectorSet, joined_rows
from tauten.model.numerics import Array, Ints
from tauten.model.points import AttachedPoints, Entries
from tauten.model.rows import EffectorRows, Rows


@dataclass(frozen=True, slots=True)
class BeamEffectors:
    """Effectors over points attached to the nodes of beams.

    The points of a frame are its origin and the axes of its node: for axis k the difference of two
    points of the node, at the distance e_k and at the node itself, so that A of (E1) is the node's rotation.

    Attributes:
        kinds: the effectors as functions of the points.
        points: the points.
    """

    kinds: EffectorSet
    points: AttachedPoints

    def positions(self, x: Array, Q: Array) -> Array:
        """Positions (p, 3) of the effectors [m].

        Args:
            x: (n_nodes, 3) node positions [m].
            Q: (n_nodes, 4) node rotations.
        """
        return self.kinds.positions(self.points.place(x, Q)[0])

    def values(self, x: Array, Q: Array) -> Array:
        """Goal values (n_v,) of the effectors; arguments as of `positions`."""
        return self.kinds.values(self.points.place(x, Q)[0])

    def rows(self, x: Array, Q: Array, dof: Ints, n: int) -> EffectorRows:
        """Rows of the effectors.

        Args:
            x: (n_nodes, 3) node positions [m].
            Q: (n_nodes, 4) node rotations.
            dof: (n_nodes,) first degree of freedom of a node, −1 where it is fixed.
            n: number of degrees of freedom.
        """
        y, arms = self.points.place(x, Q)
        if self.kinds.one_point_each:
            H = self.points.velocity_map(arms, dof, n)
            return EffectorRows(H, y.ravel(), y.ravel(), y)
        found = self.kinds.measured(y)
        entries = self._entries([item.gradient for item in found])
        return joined_rows(found, self.points.rows(arms, dof, n, entries))

    def force_rows(self, x: Array, Q: Array, dof: Ints, n: int) -> Rows:
        """Positions (3 p,) of the places where outer forces act; arguments as of `rows`.

        Args:
            x: (n_nodes, 3) node positions [m].
            Q: (n_nodes, 4) node rotations.
            dof: (n_nodes,) first degree of freedom of a node, −1 where it is fixed.
            n: number of degrees of freedom.
        """
        y, arms = self.points.place(x, Q)
        blocks = [
            measure.carrier[None, :, None] * np.eye(3)[:, None] for measure in self.kinds.measures
        ]
        H = self.points.rows(arms, dof, n, self._entries(blocks))
        starts = self.kinds.starts
        places = [
            measure.carrier @ y[starts[i] : starts[i + 1]]
            for i, measure in enumerate(self.kinds.measures)
        ]
        return Rows(H, np.concatenate(places))

    def _entries(self, gradients: list[Array]) -> Entries:
        """Rows over points as sums of vectorᵀ δx_point, of gradients (m, P, 3) of each effector."""
        first = self.kinds.starts.tolist()
        counts = [count for part in gradients for count in [part.shape[1]] * part.shape[0]]
        points = [
            np.tile(np.arange(part.shape[1]) + first[i], part.shape[0])
            for i, part in enumerate(gradients)
        ]
        vectors = [part.reshape(-1, 3) for part in gradients]
        return Entries(np.cumsum([0, *counts]), np.concatenate(points), np.concatenate(vectors))
