"""Rows over points, and the motion of a body, which turns these into rows over its unknowns.

What a cable, a chamber, an effector or a contact does is a sum of vectorᵀ δx over points, whatever the
points are fixed to: `Entries`. What a body does is to place points and to know how they move with its
unknowns: `Motion` and `Placed`, one implementation for each kind of coordinates.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np
import scipy.sparse as sp

from tauten.model.numerics import Array, Ints, kernel
from tauten.model.rows import ChainedRows, Jacobian, Rows, sparse_rows

P = TypeVar("P")
P_contra = TypeVar("P_contra", contravariant=True)


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

    def of_points(self, first: int, end: int) -> tuple[Ints, Entries]:
        """Which rows (k,) points first … end − 1 contribute to, and these contributions over these points."""
        given = self.starts, self.points, self.vectors
        rows, starts, points, vectors = _of_points(*given, first, end)
        return rows, Entries(starts, points, vectors)


@dataclass(frozen=True, slots=True)
class Placed(ABC):
    """Points at one state.

    Attributes:
        y: (p, 3) positions [m].
    """

    y: Array

    @abstractmethod
    def rows(self, entries: Entries) -> Jacobian:
        """Rows (m, n) over the unknowns, of rows over these points."""

    def many_rows(self, entries: Entries, delta: Array) -> Rows | ChainedRows:
        """The same with the values delta (m,) of rows of which only some are used."""
        return Rows(self.rows(entries), delta)

    def motion(self) -> Jacobian:
        """Derivative of the positions by the unknowns: (3 p, n)."""
        return self.rows(coordinates(len(self.y)))


class Motion(Protocol[P_contra]):
    """A body at one state: where its points are, and how they move with its unknowns.

    Points are of the type that a body of this kind has: combinations of nodes, points attached to nodes that
    turn, or points moved by modes.
    """

    @property
    def n(self) -> int:
        """Unknowns."""

    @property
    def travel(self) -> Array:
        """Values (d,) of the coordinates that motors move directly, drives and drums; most have none."""

    def placed(self, points: P_contra) -> Placed:
        """Points of the body at this state."""

    def units(self, columns: Ints) -> Jacobian:
        """Unit rows (m, n) of some unknowns (m,)."""


def coordinates(count: int) -> Entries:
    """The coordinates of points as rows over them, 3 rows a point."""
    rows = np.arange(3 * count + 1)
    return Entries(rows, rows[:-1] // 3, np.tile(np.eye(3), (count, 1)))


def sparse_units(columns: Ints, n: int) -> sp.csr_array:
    """Unit rows (m, n) of some unknowns (m,)."""
    m = len(columns)
    return sparse_rows(np.ones(m), columns, np.arange(m + 1), n)


def dense_units(columns: Ints, n: int) -> Array:
    """Unit rows (m, n) of some unknowns (m,)."""
    units = np.zeros((len(columns), n))
    units[np.arange(len(columns)), columns] = 1.0
    return units


@dataclass(frozen=True, slots=True)
class PlacedByMap(Placed):
    """Points whose derivative by the unknowns is known, sparse or dense.

    Attributes, beside those of all placed points:
        map: (3 p, n) their derivative.
    """

    map: Jacobian

    def rows(self, entries: Entries) -> Jacobian:
        """Rows (m, n) over the unknowns, of rows over these points."""
        starts, points, vectors = entries.starts, entries.points, entries.vectors
        if isinstance(self.map, np.ndarray):
            H = np.zeros((len(starts) - 1, self.map.shape[1]))
            mapped_rows(starts, points, vectors, self.map, H)
            return H
        columns = (3 * points[:, None] + np.arange(3)).ravel()
        shape = (len(starts) - 1, self.map.shape[0])
        return sp.csr_array((vectors.ravel(), columns, 3 * starts), shape=shape) @ self.map

    def motion(self) -> Jacobian:
        """Derivative of the positions by the unknowns: (3 p, n)."""
        return self.map


@kernel
def _of_points(
    starts: Ints, points: Ints, vectors: Array, first: int, end: int
) -> tuple[Ints, Ints, Ints, Array]:
    """`Entries.of_points`."""
    rows, own_starts = np.empty(len(starts), np.int64), np.zeros(len(starts), np.int64)
    own_points, own_vectors = np.empty(len(points), np.int64), np.empty((len(points), 3))
    k, count = 0, 0
    for row in range(len(starts) - 1):
        for e in range(starts[row], starts[row + 1]):
            if first <= points[e] < end:
                own_points[count] = points[e] - first
                for i in range(3):
                    own_vectors[count, i] = vectors[e, i]
                count += 1
        if count > own_starts[k]:
            rows[k], own_starts[k + 1] = row, count
            k += 1
    return rows[:k], own_starts[: k + 1], own_points[:count], own_vectors[:count]


@kernel
def mapped_rows(starts: Ints, points: Ints, vectors: Array, map: Array, H: Array) -> None:
    """`PlacedByMap.rows` of a dense map.

    Args:
        starts: (m + 1,) as in `Entries`.
        points: (e,) as in `Entries`.
        vectors: (e, 3) as in `Entries`.
        map: (3 p, n) derivative of the points.
        H: (m, n) zeros, to which the rows are added.
    """
    n = map.shape[1]
    for r in range(H.shape[0]):
        h, begin, end = H[r], starts[r], starts[r + 1]
        if (end - begin) % 2 == 1:
            f = 3 * points[begin]
            v0, v1, v2 = vectors[begin, 0], vectors[begin, 1], vectors[begin, 2]
            x, y, z = map[f], map[f + 1], map[f + 2]
            for j in range(n):
                h[j] += v0 * x[j] + v1 * y[j] + v2 * z[j]
            begin += 1
        for e in range(begin, end, 2):  # two at a time: h is read and written half as often
            f, g = 3 * points[e], 3 * points[e + 1]
            v0, v1, v2 = vectors[e, 0], vectors[e, 1], vectors[e, 2]
            w0, w1, w2 = vectors[e + 1, 0], vectors[e + 1, 1], vectors[e + 1, 2]
            x, y, z, a, b, c = map[f], map[f + 1], map[f + 2], map[g], map[g + 1], map[g + 2]
            for j in range(n):
                first, second = v0 * x[j] + v1 * y[j] + v2 * z[j], w0 * a[j] + w1 * b[j] + w2 * c[j]
                h[j] += first + second


@dataclass(frozen=True, slots=True)
class OuterForces(Generic[P]):
    """Forces of fixed direction on points of type P.

    Attributes:
        points: the points.
        vectors: (p, 3) [N].
    """

    points: P
    vectors: Array

    def __bool__(self) -> bool:
        return bool(self.vectors.any())

    def on(self, motion: Motion[P]) -> Array:
        """Forces (n,) on the unknowns of a body [N]."""
        count = len(self.vectors)
        entries = Entries(np.array([0, count]), np.arange(count), self.vectors)
        force: Array = motion.placed(self.points).rows(entries).T @ np.ones(1)
        return force

    def work(self, motion: Motion[P], rest: Motion[P]) -> float:
        """Work of the forces on the way from one state to another [J]."""
        moved = motion.placed(self.points).y - rest.placed(self.points).y
        return float(np.vdot(self.vectors, moved))
