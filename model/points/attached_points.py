"""Points attached to beams: their positions and velocities, and the forces on the nodes from forces on them.

A point is attached to one node, or to two with weights that sum to one:

    x_P = Σ_a w_a (x_a + R_a ρ_a)
    δx_P = Σ_a w_a (δx_a + δθ_a x R_a ρ_a) = J δq                                  (B3)

A force f on a point acts on the nodes through the transpose: the force w_a f and the moment
w_a R_a ρ_a x f. Any row that is linear in the velocities of points becomes a row of the robot this way, and
the power is the same on both sides.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from tauten.model.numerics import Array, Ints, cross, joined, kernel, quaternion, rotate, row, scale
from tauten.model.points.entries import Entries, Placed, sparse_units
from tauten.model.rows import sparse_rows


@dataclass(frozen=True, slots=True)
class AttachedPoints:
    """Points attached to nodes that move and turn.

    Attributes:
        nodes: (p, 2) the nodes; the second is used only where its weight is not zero.
        weights: (p, 2) w, rows sum to one.
        offsets: (p, 2, 3) ρ, from each node to the point, in the node's axes [m].
    """

    nodes: Ints
    weights: Array
    offsets: Array

    def __len__(self) -> int:
        return len(self.nodes)

    def at(self, chosen: Ints) -> AttachedPoints:
        """Some of the points, by their numbers (c,)."""
        return AttachedPoints(self.nodes[chosen], self.weights[chosen], self.offsets[chosen])

    def place(self, x: Array, Q: Array) -> tuple[Array, Array]:
        """Positions (p, 3) and arms w_a R_a ρ_a (p, 2, 3) [m] at nodes x (n_nodes, 3) [m], Q (n_nodes, 4)."""
        return place(x, Q, self.nodes, self.weights, self.offsets)

    def at_rest(self, nodes: Array) -> Array:
        """Positions (p, 3) where no node of nodes (n_nodes, 3) has turned [m]."""
        return self.place(nodes, np.tile([1.0, 0.0, 0.0, 0.0], (len(nodes), 1)))[0]


@dataclass(frozen=True, slots=True)
class PoseMotion:
    """Nodes that move and turn at one state, a `Motion` of `AttachedPoints`.

    Attributes:
        x: (n_nodes, 3) positions [m].
        Q: (n_nodes, 4) rotations, unit quaternions.
        dof: (n_nodes,) first of the six degrees of freedom of a node, −1 where it is fixed.
        n: unknowns.
    """

    x: Array
    Q: Array
    dof: Ints
    n: int

    travel = np.zeros(0)  # motors move no unknown directly

    def placed(self, points: AttachedPoints) -> PlacedOnBeams:
        """Points of the body at this state."""
        return PlacedOnBeams(*points.place(self.x, self.Q), points, self.dof, self.n)

    def units(self, columns: Ints) -> sp.csr_array:
        """Unit rows (m, n) of some unknowns (m,)."""
        return sparse_units(columns, self.n)


@dataclass(frozen=True, slots=True)
class PlacedOnBeams(Placed):
    """Attached points at one state of nodes whose positions and rotations are the unknowns.

    Attributes, beside those of all placed points:
        arms: (p, 2, 3) weighted lever arms [m].
        points: the points.
        dof: (n_nodes,) first degree of freedom of a node, −1 where it is fixed.
        n: number of degrees of freedom.
    """

    arms: Array
    points: AttachedPoints
    dof: Ints
    n: int

    def rows(self, entries: Entries) -> sp.csr_array:
        """Rows (m, n) over the unknowns, of rows over these points."""
        data, columns, starts = pull_back(
            entries.starts, entries.points, entries.vectors,
            self.points.nodes, self.points.weights, self.arms, self.dof,
        )  # fmt: skip
        return sparse_rows(data, columns, starts, self.n)


def attach_to_nodes(nodes: Array, ids: Ints, points: Array) -> AttachedPoints:
    """Points that are attached to one node each.

    Args:
        nodes: (n_nodes, 3) nodes at rest [m].
        ids: (p,) the node of each point.
        points: (p, 3) positions at rest [m].
    """
    ids = np.asarray(ids, dtype=np.int64)
    weights = np.tile([1.0, 0.0], (len(ids), 1))
    offset = points - nodes[ids]
    return AttachedPoints(
        np.stack([ids, ids], axis=1), weights, np.stack([offset, np.zeros_like(offset)], axis=1)
    )


def attach_between(nodes: Array, ends: Ints, share: Array, points: Array) -> AttachedPoints:
    """Points that are attached to two nodes each.

    Args:
        nodes: (n_nodes, 3) nodes at rest [m].
        ends: (p, 2) the two nodes.
        share: (p,) in 0 … 1, weight of the second.
        points: (p, 3) positions at rest [m].
    """
    weights = np.stack([1.0 - share, share], axis=1)
    return AttachedPoints(np.asarray(ends, dtype=np.int64), weights, points[:, None] - nodes[ends])


def no_attached_points() -> AttachedPoints:
    """No points."""
    none = np.zeros((0, 2), dtype=np.int64)
    return AttachedPoints(none, np.zeros((0, 2)), np.zeros((0, 2, 3)))


def join_attached_points(parts: list[AttachedPoints]) -> AttachedPoints:
    """All points one after the other."""
    return joined([no_attached_points(), *parts])


@kernel
def place(x: Array, Q: Array, nodes: Ints, weights: Array, offsets: Array) -> tuple[Array, Array]:
    """`AttachedPoints.place`; arguments as there and in the attributes.

    Args:
        x: (n_nodes, 3) node positions [m].
        Q: (n_nodes, 4) node rotations.
        nodes: (p, 2) nodes of the points.
        weights: (p, 2) of the nodes.
        offsets: (p, 2, 3) from the nodes at rest [m].
    """
    points, arms = np.zeros((nodes.shape[0], 3)), np.zeros((nodes.shape[0], 2, 3))
    for p in range(nodes.shape[0]):
        for a in range(2):
            w = weights[p, a]
            if w == 0.0:
                continue
            arm = rotate(quaternion(Q, nodes[p, a]), row(offsets[p], a))
            for i in range(3):
                arms[p, a, i] = w * arm[i]
                points[p, i] += w * x[nodes[p, a], i] + arms[p, a, i]
    return points, arms


@kernel
def pull_back(
    starts: Ints, points: Ints, vectors: Array, nodes: Ints, weights: Array, arms: Array, dof: Ints
) -> tuple[Array, NDArray[np.int32], NDArray[np.int32]]:
    """CSR data, columns and row starts of `PlacedOnBeams.rows`; every node occurs once in a row.

    Args:
        starts: (m + 1,) as in `Entries`.
        points: (e,) as in `Entries`.
        vectors: (e, 3) as in `Entries`.
        nodes: (p, 2) nodes of the points.
        weights: (p, 2) their weights.
        arms: (p, 2, 3) weighted lever arms [m].
        dof: (n_nodes,) first degree of freedom of a node, −1 where it is fixed.
    """
    m = starts.shape[0] - 1
    sides = 2 if (weights[:, 1] != 0.0).any() else 1
    most = sides * points.shape[0]
    data, columns = np.empty(6 * most), np.empty(6 * most, np.int32)
    indptr = np.zeros(m + 1, np.int32)
    end = 0
    for r in range(m):
        begin = end
        for e in range(starts[r], starts[r + 1]):
            p = points[e]
            for a in range(sides):
                w, first = weights[p, a], dof[nodes[p, a]]
                if w == 0.0 or first < 0:
                    continue
                at = begin
                while at < end and columns[at] != first:
                    at += 6
                if at == end:
                    end += 6
                    for i in range(6):
                        columns[at + i], data[at + i] = first + i, 0.0
                f = row(vectors, e)
                moment = cross(row(arms[p], a), f)
                force = scale(w, f)
                for i in range(3):
                    data[at + i] += force[i]
                    data[at + 3 + i] += moment[i]
        indptr[r + 1] = end
    return data[:end], columns[:end], indptr
