"""Points of several parts at one state, and how they move with the unknowns of all parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import Any

import numpy as np
import scipy.sparse as sp

from tauten.model.numerics import Array, Ints, kernel
from tauten.model.parts.part import Placement
from tauten.model.points import Entries, Motion, Placed, sparse_units
from tauten.model.rows import Jacobian, dense, sparse_rows

_NONE = np.zeros(0, np.int64)


def slices(sizes: Sequence[int]) -> tuple[slice, ...]:
    """Successive slices of these sizes."""
    ends = list(accumulate(sizes, initial=0))
    return tuple(map(slice, ends[:-1], ends[1:]))


@dataclass(frozen=True, slots=True, eq=False)
class PointsOfPart:
    """Points of a part, by its number, of the type its body has; without placement in its own frame."""

    part: int
    points: Any
    placement: Placement | None


@dataclass(frozen=True, slots=True, eq=False)
class PartsPoints:
    """Points of several parts, one group after the other."""

    groups: tuple[PointsOfPart, ...]


@dataclass(frozen=True, slots=True, eq=False)
class PartsMotion:
    """Several parts at one state, and the columns of their unknowns; a `Motion` of `PartsPoints`."""

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

    def placed(self, points: PartsPoints) -> Placed:
        """Points of the parts at this state; where one part is the robot, as its body places them."""
        groups = points.groups
        if len(groups) == len(self.parts) == 1 and groups[0].placement is None:
            return self.parts[0].placed(groups[0].points)
        placed = tuple(self.parts[group.part].placed(group.points) for group in groups)
        y = [
            one.y if group.placement is None else group.placement.points(one.y)
            for group, one in zip(groups, placed, strict=True)
        ]
        joined = y[0] if len(y) == 1 else np.concatenate([np.zeros((0, 3)), *y])
        return PlacedOnParts(joined, groups, placed, self.columns)

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
        if len(self.groups) == 1:
            shares = [(self.groups[0], self.placed[0], np.arange(m), entries)]
        else:
            spans = slices([len(one.y) for one in self.placed])
            shares = [
                (group, one, *entries.of_points(span.start, span.stop))
                for group, one, span in zip(self.groups, self.placed, spans, strict=True)
            ]
        moving = [share for share in shares if len(share[2]) > 0] or shares
        blocks: list[tuple[int, Ints, Jacobian]] = []
        for group, one, rows, own in moving:
            if group.placement is not None:
                own = Entries(own.starts, own.points, group.placement.into_part(own.vectors))
            blocks.append((group.part, rows, one.rows(own)))
        return in_columns(blocks, self.columns, m)

    def motion(self) -> Jacobian:
        """Derivative of the positions by the unknowns: (3 p, n)."""
        if len(self.groups) > 1 or self.groups[0].placement is not None:
            return super(PlacedOnParts, self).motion()
        own = self.placed[0].motion()
        every = np.arange(3 * len(self.y))
        return in_columns([(self.groups[0].part, every, own)], self.columns, len(every))


def in_columns(
    blocks: Sequence[tuple[int, Ints, Jacobian]], columns: tuple[slice, ...], m: int
) -> Jacobian:
    """Rows over the unknowns of all parts, dense where those of a part are.

    Args:
        blocks: number of a part, numbers (k,) of rows, and what (k, n of the part) is added to these.
        columns: unknowns of each part.
        m: number of rows.
    """
    n = int(columns[-1].stop)
    if len(columns) == 1 and len(blocks) == 1 and len(blocks[0][1]) == m:
        return blocks[0][2]
    sparse = [
        (columns[part].start, rows, block)
        for part, rows, block in blocks
        if isinstance(block, sp.csr_array)
    ]
    if len(sparse) < len(blocks):
        H = np.zeros((m, n))
        for part, rows, block in blocks:
            _add_rows(dense(block), rows, columns[part].start, H)
        return H
    # side by side without scipy's sums, which check and compress every one
    row = np.concatenate(
        [_NONE, *(np.repeat(rows, np.diff(one.indptr)) for _, rows, one in sparse)]
    )
    order = np.argsort(row, kind="stable")
    column = np.concatenate([_NONE, *(one.indices + first for first, _, one in sparse)])[order]
    data = np.concatenate([np.zeros(0), *(one.data for _, _, one in sparse)])[order]
    starts = np.concatenate([[0], np.bincount(row, minlength=m).cumsum()])
    return sparse_rows(data, column, starts, n)


@kernel
def _add_rows(block: Array, rows: Ints, first: int, H: Array) -> None:
    """Add a block (k, r) to some rows (k,) of H (m, n), from column `first` on."""
    for k in range(len(rows)):
        for j in range(block.shape[1]):
            H[rows[k], first + j] += block[k, j]


def stacked(blocks: Sequence[Jacobian]) -> Jacobian:
    """Rows (m, n of the part) of every part below those before: (Σ m, n), dense where those of a part are."""
    sparse = [block for block in blocks if isinstance(block, sp.csr_array)]
    if len(sparse) == len(blocks):
        widths = [block.shape[1] for block in sparse]
        entries, left = (slices(sizes) for sizes in ([one.nnz for one in sparse], widths))
        starts = [one.indptr[:-1] + at.start for one, at in zip(sparse, entries, strict=True)]
        column = [one.indices + at.start for one, at in zip(sparse, left, strict=True)]
        starts.append(np.array([entries[-1].stop]))
        data = np.concatenate([one.data for one in sparse])
        return sparse_rows(data, np.concatenate(column), np.concatenate(starts), sum(widths))
    shapes = [block.shape for block in blocks]
    below, right = (slices(sizes) for sizes in zip(*shapes, strict=True))
    H = np.zeros((below[-1].stop, right[-1].stop))
    for block, rows, columns in zip(blocks, below, right, strict=True):
        H[rows, columns] = dense(block)
    return H
