"""Points of several parts at one state, and how they move with the unknowns of all parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from tauten.model.numerics import Array, Ints
from tauten.model.parts.part import Placement
from tauten.model.points import Entries, Motion, Placed, sparse_units
from tauten.model.rows import Jacobian, dense

_NONE = np.zeros(0, np.int64)


def slices(sizes: Sequence[int]) -> tuple[slice, ...]:
    """Successive slices of these sizes."""
    ends = list(accumulate(sizes, initial=0))
    return tuple(map(slice, ends[:-1], ends[1:]))


@dataclass(frozen=True, slots=True, eq=False)
class PointsOfPart:
    """Points of one part.

    Attributes:
        part: its number.
        points: of the type that its body has.
        placement: where its frame stands; None: positions are given in its own frame.
    """

    part: int
    points: Any
    placement: Placement | None


@dataclass(frozen=True, slots=True, eq=False)
class PartsPoints:
    """Points of several parts, one group after the other.

    Attributes:
        groups: the points.
    """

    groups: tuple[PointsOfPart, ...]


@dataclass(frozen=True, slots=True, eq=False)
class PartsMotion:
    """Several parts at one state, a `Motion` of `PartsPoints`.

    Attributes:
        parts: of each part.
        columns: unknowns of each part.
    """

    parts: tuple[Motion[Any], ...]
    columns: tuple[slice, ...]

    @property
    def n(self) -> int:
        """Unknowns of all parts."""
        return int(self.columns[-1].stop)

    @property
    def travel(self) -> Array:
        """Values (d,) of the coordinates that motors move directly, part by part."""
        return np.concatenate([part.travel for part in self.parts])

    def placed(self, points: PartsPoints) -> PlacedOnParts:
        """Points of the parts at this state."""
        placed = tuple(self.parts[group.part].placed(group.points) for group in points.groups)
        y = [
            one.y if group.placement is None else group.placement.points(one.y)
            for group, one in zip(points.groups, placed, strict=True)
        ]
        return PlacedOnParts(
            np.concatenate([np.zeros((0, 3)), *y]), points.groups, placed, self.columns
        )

    def units(self, columns: Ints) -> sp.csr_array:
        """Unit rows (m, n) of some unknowns (m,)."""
        return sparse_units(columns, self.n)


@dataclass(frozen=True, slots=True, eq=False)
class PlacedOnParts(Placed):
    """Points of several parts at one state.

    Attributes, beside those of all placed points:
        groups: the points.
        placed: each group in the frame of its part.
        columns: unknowns of each part.
    """

    groups: tuple[PointsOfPart, ...]
    placed: tuple[Placed, ...]
    columns: tuple[slice, ...]

    def rows(self, entries: Entries) -> Jacobian:
        """Rows (m, n) over the unknowns, of rows over these points."""
        m = len(entries.starts) - 1
        row = np.repeat(np.arange(m), np.diff(entries.starts))
        blocks: list[tuple[int, Jacobian]] = []
        spans = slices([len(one.y) for one in self.placed])
        for group, one, span in zip(self.groups, self.placed, spans, strict=True):
            chosen = (entries.points >= span.start) & (entries.points < span.stop)
            vectors = entries.vectors[chosen]
            if group.placement is not None:
                vectors = group.placement.into_part(vectors)
            starts = np.concatenate([[0], np.bincount(row[chosen], minlength=m).cumsum()])
            own = Entries(starts, entries.points[chosen] - span.start, vectors)
            blocks.append((group.part, one.rows(own)))
        return in_columns(blocks, self.columns, m)


def in_columns(
    blocks: Sequence[tuple[int, Jacobian]], columns: tuple[slice, ...], m: int
) -> Jacobian:
    """Rows over the unknowns of all parts, dense where those of a part are.

    Args:
        blocks: number of a part, and rows (m, n of the part) over its unknowns, which are added.
        columns: unknowns of each part.
        m: number of rows.
    """
    n = int(columns[-1].stop)
    sparse = [
        (columns[part].start, block) for part, block in blocks if isinstance(block, sp.csr_array)
    ]
    if len(sparse) < len(blocks):
        H = np.zeros((m, n))
        for part, block in blocks:
            H[:, columns[part]] += dense(block)
        return H
    # side by side without scipy's sums, which check and compress every one
    found = [(first, block) for first, block in sparse if block.nnz > 0]
    row = np.concatenate(
        [_NONE, *(np.repeat(np.arange(m), np.diff(one.indptr)) for _, one in found)]
    )
    order = np.argsort(row, kind="stable")
    column = np.concatenate([_NONE, *(one.indices + first for first, one in found)])[order]
    data = np.concatenate([np.zeros(0), *(one.data for _, one in found)])[order]
    starts = np.sum([np.zeros(m + 1, np.int64), *(one.indptr for _, one in found)], axis=0)
    return sp.csr_array((data, column, starts), shape=(m, n))


def stacked(blocks: Sequence[Jacobian]) -> Jacobian:
    """Rows (m, n of the part) of every part below those before: (Σ m, n), dense where those of a part are."""
    sparse = [block for block in blocks if isinstance(block, sp.csr_array)]
    if len(sparse) == len(blocks):
        heights, widths = zip(*(block.shape for block in sparse), strict=True)
        entries, left = (slices(sizes) for sizes in ([one.nnz for one in sparse], widths))
        starts = [one.indptr[:-1] + at.start for one, at in zip(sparse, entries, strict=True)]
        column = [one.indices + at.start for one, at in zip(sparse, left, strict=True)]
        starts.append(np.array([entries[-1].stop]))
        arrays = [one.data for one in sparse], column, starts
        return sp.csr_array(
            tuple(np.concatenate(part) for part in arrays), shape=(sum(heights), sum(widths))
        )
    H: Array = scipy.linalg.block_diag(*map(dense, blocks))
    return H
