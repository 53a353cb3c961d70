"""Effectors of robots whose configuration is the positions of nodes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from tauten.model.effectors.effector_set import EffectorSet
from tauten.model.numerics import Array, Ints
from tauten.model.points import PlacedByMap
from tauten.model.rows import EffectorRows


@dataclass(frozen=True, slots=True)
class NodalEffectors:
    """Effectors over points that are linear combinations of nodes.

    Attributes:
        kinds: the effectors as functions of the points.
        coefficients: (P, n_nodes) of the nodes in the points.
        C: (3 P, n) derivative of the points by the degrees of freedom, constant.
    """

    kinds: EffectorSet
    coefficients: sp.csr_array
    C: sp.csr_array

    def points(self, x: Array) -> Array:
        """Positions (P, 3) of the points for node positions x (n_nodes, 3) [m]."""
        return np.asarray(self.coefficients @ x)

    def placed(self, x: Array) -> PlacedByMap:
        """The points at node positions x (n_nodes, 3) [m]."""
        return PlacedByMap(self.points(x), self.C)

    def positions(self, x: Array) -> Array:
        """Positions (p, 3) of the effectors for node positions x (n_nodes, 3) [m]."""
        return self.kinds.positions(self.points(x))

    def values(self, x: Array) -> Array:
        """Goal values (n_v,) for node positions x (n_nodes, 3) [m]."""
        return self.kinds.values(self.points(x))

    def rows(self, x: Array) -> EffectorRows:
        """Rows at node positions x (n_nodes, 3) [m]."""
        return self.kinds.rows(self.placed(x))


def nodal_effectors(
    kinds: EffectorSet, coefficients: sp.csr_array, dof: Ints, n: int
) -> NodalEffectors:
    """Effectors over combinations of nodes.

    Args:
        kinds: the effectors as functions of the points.
        coefficients: (P, n_nodes) of the nodes in the points.
        dof: (n_nodes,) first degree of freedom of a node, −1 where it is fixed.
        n: number of degrees of freedom.
    """
    entries = sp.coo_array(coefficients)
    point, node = entries.coords
    free = dof[node] >= 0
    row = 3 * point[free][:, None] + np.arange(3)
    column = dof[node[free]][:, None] + np.arange(3)
    data = np.repeat(entries.data[free], 3)
    C = sp.csr_array((data, (row.ravel(), column.ravel())), shape=(3 * coefficients.shape[0], n))
    return NodalEffectors(kinds, coefficients, C)
