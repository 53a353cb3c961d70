"""Effectors of robots made of beams, over points attached to nodes."""

from __future__ import annotations

from dataclasses import dataclass

from tauten.model.effectors.effector_set import EffectorSet
from tauten.model.numerics import Array, Ints
from tauten.model.points import AttachedPoints
from tauten.model.rows import EffectorRows


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
        return self.kinds.rows(self.points.placed(x, Q, dof, n))
