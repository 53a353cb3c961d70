"""Forces of fixed direction: δ is the displacement along it, a constant row."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from tauten.model.numerics import Array, Ints
from tauten.model.rows import Rows


@dataclass(frozen=True, slots=True)
class PointForce:
    """A force on a weighted sum of nodes.

    Attributes:
        nodes: (s,) node ids.
        weights: (s,) their weights, which sum to one.
        direction: (3,) unit vector.
    """

    nodes: Ints
    weights: Array
    direction: Array


@dataclass(frozen=True, slots=True)
class ForceSet:
    """All forces of a robot.

    Attributes:
        H: (f, n) constant rows.
        rest: (f,) H q₀ [m].
        weights: (f, n_nodes) of the nodes in the point of each force.
        directions: (f, 3) unit vectors.
    """

    H: sp.csr_array
    rest: Array
    weights: sp.csr_array
    directions: Array

    def __len__(self) -> int:
        return len(self.rest)

    def segments(self, x: Array) -> Array:
        """Points of the forces at node positions x (n_nodes, 3), and one metre along them: (f, 2, 3) [m]."""
        points = self.weights @ x
        return np.stack([points, points + self.directions], axis=1)

    def rows(self, q: Array) -> Rows:
        """Displacements along the directions: Rows of (f, n) [m].

        Args:
            q: (n,) positions of the free nodes [m].
        """
        return Rows(self.H, self.H @ q - self.rest)


def make_forces(forces: list[PointForce], x0: Array, dof: Ints, n: int) -> ForceSet:
    """Rows of the forces.

    Args:
        forces: of the robot.
        x0: (n_nodes, 3) node positions at rest [m].
        dof: (n_nodes,) first degree of freedom of a node, −1 where it is fixed.
        n: number of degrees of freedom.
    """
    data, columns, starts = [np.zeros(0)], [np.zeros(0, dtype=np.int64)], [0]
    for force in forces:
        first = dof[force.nodes]  # (s,)
        free = first >= 0
        data.append(np.outer(force.weights[free], force.direction).ravel())
        columns.append((first[free, None] + np.arange(3)).ravel())
        starts.append(starts[-1] + len(data[-1]))
    H = sp.csr_array((np.concatenate(data), np.concatenate(columns), starts), (len(forces), n))
    H.sum_duplicates()
    counts = [len(force.nodes) for force in forces]
    nodes = np.concatenate([np.zeros(0, dtype=np.int64), *(force.nodes for force in forces)])
    shares = np.concatenate([np.zeros(0), *(force.weights for force in forces)])
    weights = sp.csr_array((shares, nodes, np.cumsum([0, *counts])), (len(forces), len(x0)))
    directions = np.array([force.direction for force in forces]).reshape(-1, 3)
    return ForceSet(H, np.asarray(H @ x0[dof >= 0].ravel()), weights, directions)
