"""Constraint rows: the contribution of a cable, an effector or a contact to a step."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, replace
from typing import Protocol, TypeAlias

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from tauten.model.contacts import Contacts, no_contacts
from tauten.model.numerics import Array, Ints, kernel

# Sparse where the unknowns are the mesh's, dense where they are the few of a state basis.
Jacobian: TypeAlias = sp.csr_array | Array
_Places: TypeAlias = Ints | NDArray[np.int32]
_EMPTY = sp.csr_array((0, 0))


@dataclass(frozen=True, slots=True)
class Rows:
    """Constraint rows δ(q) and their Jacobian H = ∂δ/∂q.

    Attributes:
        H: (m, n), row values per configuration change.
        delta: (m,) row values [m].
    """

    H: Jacobian
    delta: Array

    def __len__(self) -> int:
        return int(self.delta.shape[0])

    @property
    def n(self) -> int:
        """Unknowns."""
        return int(self.H.shape[1])

    def dense(self) -> Array:
        """H (m, n) as a dense array."""
        return self.H if isinstance(self.H, np.ndarray) else dense(self.H)

    def chosen(self, rows: Ints) -> Array:
        """Some rows (r,) of H as a dense array: (r, n)."""
        if isinstance(self.H, np.ndarray):
            return self.H[rows]
        return _chosen(rows, self.H.indptr, self.H.indices, self.H.data, self.n)

    def weighed(self, lam: Array) -> Array:
        """Hᵀ λ (n,) for forces lam (m,) on the rows."""
        H = self.H
        if isinstance(H, np.ndarray):
            found: Array = H.T @ lam
            return found
        entries = H.data * np.repeat(lam, np.diff(H.indptr))
        along: Array = np.bincount(H.indices, entries, self.n).astype(float, copy=False)
        return along

    def in_order(self, rows: Ints) -> Rows:
        """The same rows in an order (m,), or some of them."""
        H = self.H
        if isinstance(H, np.ndarray):
            return Rows(H[rows], self.delta[rows])
        lengths = np.diff(H.indptr)[rows]
        starts = np.concatenate([[0], np.cumsum(lengths)])
        entries = np.repeat(H.indptr[rows] - starts[:-1], lengths) + np.arange(starts[-1])
        chosen = sparse_rows(H.data[entries], H.indices[entries], starts, self.n)
        return Rows(chosen, self.delta[rows])

    def after(self, h: float, v: Array) -> Array:
        """Row values after a time h [s] at velocity v (n,), to first order: δ + h H v (m,)."""
        if isinstance(self.H, np.ndarray):
            values: Array = self.delta + h * (self.H @ v)
            return values
        return _after(self.delta, self.H.indptr, self.H.indices, self.H.data, h, v)


@dataclass(frozen=True, slots=True)
class ChainedRows:
    """Many rows with the Jacobian H = S J: over many coordinates S, which few unknowns move by J.

    S is sparse, and the product is computed for the rows that are used.

    Attributes:
        starts: (m + 1,) where each row of S starts, as in CSR.
        columns: (nnz,) coordinate of each entry.
        data: (nnz,) entries of S.
        motion: (N, n) J.
        delta: (m,) row values [m].
    """

    starts: NDArray[np.int32]
    columns: NDArray[np.int32]
    data: Array
    motion: Array
    delta: Array

    def __len__(self) -> int:
        return len(self.delta)

    @property
    def n(self) -> int:
        """Unknowns."""
        return int(self.motion.shape[1])

    def dense(self) -> Array:
        """H (m, n) as a dense array."""
        return self.chosen(np.arange(len(self)))

    def chosen(self, rows: Ints) -> Array:
        """Some rows (r,) of H as a dense array: (r, n)."""
        return _chained(rows, self.starts, self.columns, self.data, self.motion)

    def after(self, h: float, v: Array) -> Array:
        """Row values after a time h [s] at velocity v (n,), to first order: δ + h H v (m,)."""
        return _after(self.delta, self.starts, self.columns, self.data, h, self.motion @ v)


@dataclass(frozen=True, slots=True)
class EffectorRows(Rows):
    """Rows of the effectors, with the goal values and positions they have at this state.

    Attributes:
        values: (n_v,) goal values, see `tauten.model.signals.effector_layout`.
        positions: (p, 3) of the effectors, of a distance, length or volume the mean of its points [m].
    """

    values: Array
    positions: Array


NO_EFFECTOR_ROWS = EffectorRows(np.zeros((0, 0)), np.zeros(0), np.zeros(0), np.zeros((0, 3)))


class RelativeMotion(Protocol):
    """Motion of contacts relative to what they touch; rows are made of those that are asked for."""

    def along(self, directions: Array, chosen: Ints) -> Array:
        """Rows of the motion of some contacts (r,) along unit directions (r, d, 3) of each: (r d, n)."""


@dataclass(frozen=True, slots=True)
class ContactRows:
    """Rows of the contact candidates within the alarm distance.

    Attributes:
        rows: H (m, n) and signed gaps delta (m,) [m]; positive = apart.
        found: the contacts, in the order of the rows.
        relative: motion in any direction; None where no contact in range has friction.
        frictional: whether any contact pair of the robot has friction.
    """

    rows: Rows | ChainedRows
    found: Contacts
    relative: RelativeMotion | None = None
    frictional: bool = False

    @classmethod
    def out_of_range(cls, H: Jacobian, n_slots: int, frictional: bool) -> ContactRows:
        """No candidate in range.

        Args:
            H: (0, n) no rows.
            n_slots: slots in λ_c.
            frictional: whether any contact pair of the robot has friction.
        """
        return cls(Rows(H, np.zeros(0)), no_contacts(n_slots), frictional=frictional)

    def later(self, seconds: float) -> ContactRows:
        """The same rows with the gaps where obstacles are a time later, to first order."""
        closing = self.found.closing
        if closing is None:
            return self
        rows = replace(self.rows, delta=self.rows.delta - seconds * closing)
        return replace(self, rows=rows)

    @property
    def slots(self) -> Ints:
        """Slot in λ_c of each row, ascending: (m,)."""
        return self.found.slots

    @property
    def pair(self) -> Ints:
        """Contact pair of each row: (m,)."""
        return self.found.pair

    def __len__(self) -> int:
        return len(self.rows)

    def rows_of(self, slots: Ints) -> Ints:
        """Numbers of the rows of some slots, those in range, ascending."""
        return _rows_of(self.found.slots, slots)


@kernel
def _rows_of(own: Ints, slots: Ints) -> Ints:
    """`ContactRows.rows_of`, of rows with ascending slots (m,)."""
    among = np.zeros(len(own), np.bool_)
    for slot in slots:
        row = np.searchsorted(own, slot)
        if row < len(own) and own[row] == slot:
            among[row] = True
    return np.flatnonzero(among)


@kernel
def _after(
    delta: Array,
    indptr: NDArray[np.int32],
    indices: NDArray[np.int32],
    data: Array,
    h: float,
    v: Array,
) -> Array:
    """`Rows.after` of a sparse H, faster than the general product of scipy."""
    values = delta.copy()
    for i in range(delta.shape[0]):
        change = 0.0
        for place in range(indptr[i], indptr[i + 1]):
            change += data[place] * v[indices[place]]
        values[i] += h * change
    return values


@kernel
def _chosen(
    rows: Ints, indptr: NDArray[np.int32], indices: NDArray[np.int32], data: Array, n: int
) -> Array:
    """`Rows.chosen` of a sparse H, whose entries may occur twice."""
    H = np.zeros((len(rows), n))
    for i in range(len(rows)):
        for place in range(indptr[rows[i]], indptr[rows[i] + 1]):
            H[i, indices[place]] += data[place]
    return H


@kernel
def _chained(
    rows: Ints,
    starts: NDArray[np.int32],
    columns: NDArray[np.int32],
    data: Array,
    motion: Array,
) -> Array:
    """`ChainedRows.chosen`; arguments as there and in the attributes."""
    n = motion.shape[1]
    H = np.zeros((rows.shape[0], n))
    for i in range(rows.shape[0]):
        for place in range(starts[rows[i]], starts[rows[i] + 1]):
            value, column = data[place], columns[place]
            for j in range(n):
                H[i, j] += value * motion[column, j]
    return H


@dataclass(frozen=True, slots=True)
class PairSlots:
    """Slots first … end − 1 of λ_c belong to the contact pair of this name."""

    name: str
    first: int
    end: int


def sparse_rows(data: Array, columns: _Places, starts: _Places, n: int) -> sp.csr_array:
    """Sparse rows (m, n) without scipy's checks, which take longer than what makes few rows.

    Args:
        data: (nnz,) entries; several may be in the same place.
        columns: (nnz,) of the entries.
        starts: (m + 1,) where each row starts.
        n: number of columns.
    """
    H = copy(_EMPTY)
    H.data, H._shape = data, (len(starts) - 1, n)
    H.indices, H.indptr = columns.astype(np.int32, copy=False), starts.astype(np.int32, copy=False)
    return H


def dense(H: Jacobian) -> Array:
    """A Jacobian as a dense array."""
    return H if isinstance(H, np.ndarray) else np.asarray(H.toarray())


def stack(parts: list[Rows]) -> Rows:
    """The given rows stacked: H (Σm, n), delta (Σm,)."""
    delta = np.concatenate([part.delta for part in parts])
    sparse = [part.H for part in parts if isinstance(part.H, sp.csr_array)]
    if len(sparse) < len(parts):
        return Rows(np.vstack([part.dense() for part in parts]), delta)
    data, columns = (
        np.concatenate(arrays)
        for arrays in zip(*((H.data, H.indices) for H in sparse), strict=True)
    )
    lengths = np.concatenate([np.diff(H.indptr) for H in sparse])
    starts = np.concatenate([[0], np.cumsum(lengths)])
    return Rows(sparse_rows(data, columns, starts, parts[0].n), delta)
