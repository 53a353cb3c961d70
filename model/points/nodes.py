"""Points of bodies whose nodes have positions only: combinations of nodes, and rows over them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol, TypeAlias

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from tauten.model.numerics import Array, Ints, kernel
from tauten.model.points.entries import Entries, Placed, PlacedByMap, sparse_units
from tauten.model.rows import sparse_rows

# Data, columns and row starts of sparse rows.
CsrArrays: TypeAlias = tuple[Array, NDArray[np.int32], NDArray[np.int32]]


class Through(Protocol):
    """A map from unknowns to the nodes, at one state."""

    @property
    def n(self) -> int:
        """Unknowns."""

    def rows(self, H: CsrArrays) -> sp.csr_array:
        """Rows over the unknowns, of rows H over the nodes that are not fixed."""


@dataclass(frozen=True, slots=True)
class NodeMotion:
    """Nodes at one state, a `Motion` of `NodePoints` and `MeanPoints`.

    Attributes:
        x: (n_nodes, 3) positions [m].
        dof: (n_nodes,) first degree of freedom of a node, −1 where it is fixed.
        n_free: degrees of freedom of the nodes.
        through: the map from the unknowns to these; None: they are the unknowns.
        travel: (d,) values of the coordinates that motors move directly.
    """

    x: Array
    dof: Ints
    n_free: int
    through: Through | None = None
    travel: Array = field(default_factory=lambda: np.zeros(0))

    @property
    def n(self) -> int:
        """Unknowns."""
        return self.n_free if self.through is None else self.through.n

    def placed(self, points: NodePoints | MeanPoints) -> Placed:
        """Points of the body at this state."""
        return points.on(self)

    def units(self, columns: Ints) -> sp.csr_array:
        """Unit rows (m, n) of some unknowns (m,)."""
        return sparse_units(columns, self.n)

    def over_unknowns(self, H: CsrArrays) -> sp.csr_array:
        """Rows over the unknowns, of rows H over the degrees of freedom of the nodes."""
        if self.through is not None:
            return self.through.rows(H)
        return sparse_rows(*H, self.n_free)


@dataclass(frozen=True, slots=True)
class NodePoints:
    """Points that are combinations of a few nodes each.

    Attributes:
        nodes: (p, k) nodes of each point.
        weights: (p, k) their weights; zero where a point does not move.
        fixed: (p, 3) what is added to them, the position of points that do not move [m].
    """

    nodes: Ints
    weights: Array
    fixed: Array

    def __len__(self) -> int:
        return len(self.nodes)

    def at(self, x: Array) -> Array:
        """Positions (p, 3) at node positions x (n_nodes, 3) [m]."""
        return combined(x, self.nodes, self.weights, self.fixed)

    def on(self, motion: NodeMotion) -> PlacedOnNodes:
        """The points at one state of the nodes."""
        return PlacedOnNodes(self.at(motion.x), self, motion)


def combinations(nodes: Ints, weights: Array) -> NodePoints:
    """Points that move with nodes (p, k) of weights (p, k), rows of which sum to one."""
    return NodePoints(nodes, weights, np.zeros((len(nodes), 3)))


def points_at(nodes: Ints) -> NodePoints:
    """Nodes (p,) themselves."""
    return combinations(nodes[:, None], np.ones((len(nodes), 1)))


@dataclass(frozen=True, slots=True)
class PlacedOnNodes(Placed):
    """Combinations of nodes at one state.

    Attributes, beside those of all placed points:
        points: the points.
        nodes: the state of the nodes.
    """

    points: NodePoints
    nodes: NodeMotion

    def rows(self, entries: Entries) -> sp.csr_array:
        """Rows (m, n) over the unknowns, of rows over these points."""
        starts, nodes, points = entries.starts, self.nodes, self.points
        H = node_rows(
            starts, entries.points, entries.vectors, points.nodes, points.weights, nodes.dof
        )
        return nodes.over_unknowns(H)


@dataclass(frozen=True, slots=True)
class MeanPoints:
    """Points that are sums over any number of nodes, as the mean and the moments of a region.

    Attributes:
        weights: (p, n_nodes) of the nodes in the points.
        C: (3 p, n_free) derivative of the points by the degrees of freedom of the nodes, constant.
    """

    weights: sp.csr_array
    C: sp.csr_array

    def __len__(self) -> int:
        return int(self.weights.shape[0])

    def at(self, x: Array) -> Array:
        """Positions (p, 3) at node positions x (n_nodes, 3) [m]."""
        return np.asarray(self.weights @ x)

    def on(self, motion: NodeMotion) -> PlacedByMap:
        """The points at one state of the nodes."""
        return PlacedByMap(
            self.at(motion.x), motion.over_unknowns((self.C.data, self.C.indices, self.C.indptr))
        )


def mean_points(weights: sp.csr_array, dof: Ints, n: int) -> MeanPoints:
    """Sums over nodes.

    Args:
        weights: (p, n_nodes) of the nodes in the points.
        dof: (n_nodes,) first degree of freedom of a node, −1 where it is fixed.
        n: number of degrees of freedom.
    """
    entries = sp.coo_array(weights)
    point, node = entries.coords
    free = dof[node] >= 0
    row = 3 * point[free][:, None] + np.arange(3)
    column = dof[node[free]][:, None] + np.arange(3)
    data = np.repeat(entries.data[free], 3)
    C = sp.csr_array((data, (row.ravel(), column.ravel())), shape=(3 * weights.shape[0], n))
    return MeanPoints(weights, C)


@kernel
def combined(x: Array, nodes: Ints, weights: Array, fixed: Array) -> Array:
    """Positions (p, 3) of combinations of nodes [m].

    Args:
        x: (n_nodes, 3) node positions [m].
        nodes: (p, k) nodes of the points.
        weights: (p, k) their weights.
        fixed: (p, 3) what is added to them [m].
    """
    y = fixed.copy()
    for p in range(nodes.shape[0]):
        for a in range(nodes.shape[1]):
            for i in range(3):
                y[p, i] += weights[p, a] * x[nodes[p, a], i]
    return y


@kernel
def node_rows(
    starts: Ints, points: Ints, vectors: Array, nodes: Ints, weights: Array, dof: Ints
) -> CsrArrays:
    """CSR data, columns and row starts of `PlacedOnNodes.rows` over the nodes; each occurs once in a row.

    Args:
        starts: (m + 1,) as in `Entries`.
        points: (e,) as in `Entries`.
        vectors: (e, 3) as in `Entries`.
        nodes: (p, k) nodes of the points.
        weights: (p, k) their weights.
        dof: (n_nodes,) first degree of freedom of a node, −1 where it is fixed.
    """
    m, most = starts.shape[0] - 1, points.shape[0] * nodes.shape[1]
    data, columns = np.zeros(3 * most), np.empty(3 * most, np.int32)
    indptr, seen = np.zeros(m + 1, np.int32), np.full(dof.shape[0], -1, np.int64)
    end = 0
    for r in range(m):
        begin = end
        for e in range(starts[r], starts[r + 1]):
            p = points[e]
            for a in range(nodes.shape[1]):
                w, node = weights[p, a], nodes[p, a]
                first = dof[node]
                if w == 0.0 or first < 0:
                    continue
                at = seen[node]
                if at < begin:
                    at, end = end, end + 3
                    seen[node] = at
                    for i in range(3):
                        columns[at + i] = first + i
                for i in range(3):
                    data[at + i] += w * vectors[e, i]
        indptr[r + 1] = end
    return data[:end], columns[:end], indptr
