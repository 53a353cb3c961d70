"""Rows over points, and points at one state that turn these into rows over the unknowns.

What a cable, a chamber, an effector or a contact does is a sum of vectorᵀ δx over points, whatever the
points are fixed to: `Entries`. What a body does is to place points and to know how they move with its
unknowns: `Placed`, one implementation for each kind of coordinates.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from tauten.model.numerics import Array, Ints, kernel
from tauten.model.rows import Jacobian


@dataclass(frozen=True, slots=True)
class Entries:
    """Rows over points, as sums of vectorᵀ δx_point.

    Attributes:
        starts: (m + 1,) where each row's entries start.
        points: (e,) point of each entry.
        vectors: (e, 3).
    """

    starts: Ints
    points: Ints
    vectors: Array


class Placed(Protocol):
    """Points at one state."""

    @property
    def y(self) -> Array:
        """Their positions: (p, 3) [m]."""

    def rows(self, entries: Entries) -> Jacobian:
        """Rows (m, n) over the unknowns, of rows over these points."""

    def motion(self) -> Jacobian:
        """Derivative of the positions by the unknowns: (3 p, n)."""


def coordinates(count: int) -> Entries:
    """The coordinates of points as rows over them, 3 rows a point."""
    rows = np.arange(3 * count + 1)
    return Entries(rows, rows[:-1] // 3, np.tile(np.eye(3), (count, 1)))


@dataclass(frozen=True, slots=True)
class PlacedOnNodes:
    """Points that are combinations of nodes whose positions are the unknowns.

    Attributes:
        y: (p, 3) positions [m].
        nodes: (p, k) nodes of each point.
        weights: (p, k) their weights.
        dof: (n_nodes,) first degree of freedom of a node, −1 where it is fixed.
        n: number of degrees of freedom.
    """

    y: Array
    nodes: Ints
    weights: Array
    dof: Ints
    n: int

    def rows(self, entries: Entries) -> sp.csr_array:
        """Rows (m, n) over the unknowns, of rows over these points."""
        starts, points, vectors = entries.starts, entries.points, entries.vectors
        data, columns, indptr = node_rows(
            starts, points, vectors, self.nodes, self.weights, self.dof
        )
        return sp.csr_array((data, columns, indptr), shape=(len(starts) - 1, self.n))

    def motion(self) -> sp.csr_array:
        """Derivative of the positions by the unknowns: (3 p, n)."""
        return self.rows(coordinates(len(self.y)))


def placed_nodes(x: Array, dof: Ints, n: int) -> PlacedOnNodes:
    """The nodes themselves.

    Args:
        x: (n_nodes, 3) their positions [m].
        dof: (n_nodes,) first degree of freedom of a node, −1 where it is fixed.
        n: number of degrees of freedom.
    """
    return PlacedOnNodes(x, np.arange(len(x))[:, None], np.ones((len(x), 1)), dof, n)


@dataclass(frozen=True, slots=True)
class PlacedByMap:
    """Points whose derivative by the unknowns is known, sparse or dense.

    Attributes:
        y: (p, 3) positions [m].
        map: (3 p, n) their derivative.
    """

    y: Array
    map: Jacobian

    def rows(self, entries: Entries) -> Jacobian:
        """Rows (m, n) over the unknowns, of rows over these points."""
        starts, points, vectors = entries.starts, entries.points, entries.vectors
        if isinstance(self.map, np.ndarray):
            found: Array = mapped_rows(starts, points, vectors, self.map)
            return found
        columns = (3 * points[:, None] + np.arange(3)).ravel()
        shape = (len(starts) - 1, self.map.shape[0])
        return sp.csr_array((vectors.ravel(), columns, 3 * starts), shape=shape) @ self.map

    def motion(self) -> Jacobian:
        """Derivative of the positions by the unknowns: (3 p, n)."""
        return self.map


@kernel
def node_rows(
    starts: Ints, points: Ints, vectors: Array, nodes: Ints, weights: Array, dof: Ints
) -> tuple[Array, NDArray[np.int32], NDArray[np.int32]]:
    """CSR data, columns and row starts of `PlacedOnNodes.rows`; every node occurs once in a row.

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


@kernel
def mapped_rows(starts: Ints, points: Ints, vectors: Array, map: Array) -> Array:
    """`PlacedByMap.rows` of a dense map.

    Args:
        starts: (m + 1,) as in `Entries`.
        points: (e,) as in `Entries`.
        vectors: (e, 3) as in `Entries`.
        map: (3 p, n) derivative of the points.
    """
    m, n = starts.shape[0] - 1, map.shape[1]
    H = np.zeros((m, n))
    for r in range(m):
        h = H[r]
        for e in range(starts[r], starts[r + 1]):
            f = 3 * points[e]
            v0, v1, v2 = vectors[e, 0], vectors[e, 1], vectors[e, 2]
            x, y, z = map[f], map[f + 1], map[f + 2]
            for j in range(n):
                h[j] += v0 * x[j] + v1 * y[j] + v2 * z[j]
    return H
