"""All effectors of a robot over the points that they are functions of."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tauten.model.effectors.measure import Measure, Measurement
from tauten.model.extension_error import extension_error
from tauten.model.numerics import Array, Ints
from tauten.model.points import Entries, Placed
from tauten.model.rows import EffectorRows, Rows
from tauten.model.signals import EffectorLayout


@dataclass(frozen=True)
class EffectorSet:
    """Effectors in row order, each a function of some points of one list.

    Attributes:
        layout: kinds, weights, places of rows and values.
        measures: the functions.
        starts: (p + 1,) first point of each effector.
    """

    layout: EffectorLayout
    measures: tuple[Measure, ...]
    starts: Ints

    def __len__(self) -> int:
        return len(self.measures)

    @cached_property
    def one_point_each(self) -> bool:
        """Whether rows are the positions of the points themselves."""
        return self.layout.positions_only and int(self.starts[-1]) == len(self)

    @cached_property
    def entries(self) -> Entries:
        """Which points each row depends on, without the vectors that `measured` gives."""
        return row_points(np.diff(self.layout.row_starts).tolist(), self.starts)

    def measured(self, y: Array) -> list[Measurement]:
        """Every effector for positions y (P, 3) of all points [m].

        Raises:
            ExtensionError: the function of another package has failed.
        """
        starts, found = self.starts.tolist(), list[Measurement]()
        for i, (measure, first, end) in enumerate(
            zip(self.measures, starts[:-1], starts[1:], strict=True)
        ):
            try:
                found.append(measure.at(y[first:end]))
            except Exception as error:
                if self.layout.kinds[i] != "function":
                    raise
                raise extension_error(f"effector {self.layout.names[i]!r}", error) from error
        return found

    def values(self, y: Array) -> Array:
        """Goal values (n_v,) for positions y (P, 3) of all points [m]."""
        if self.one_point_each:
            return y.ravel()
        return np.concatenate([found.values for found in self.measured(y)])

    def positions(self, y: Array) -> Array:
        """Positions (p, 3) of the effectors for positions y (P, 3) of all points [m]."""
        if self.one_point_each:
            return y
        return np.array([found.position for found in self.measured(y)])

    def rows(self, placed: Placed) -> EffectorRows:
        """Rows over the unknowns."""
        y = placed.y
        if self.one_point_each:
            return EffectorRows(placed.motion(), y.ravel(), y.ravel(), y)
        found = self.measured(y)
        vectors = np.concatenate([item.gradient.reshape(-1, 3) for item in found])
        return EffectorRows(
            placed.rows(Entries(self.entries.starts, self.entries.points, vectors)),
            np.concatenate([item.delta for item in found]),
            np.concatenate([item.values for item in found]),
            np.array([item.position for item in found]),
        )

    def places(self, placed: Placed) -> Rows:
        """Positions (3 p,) of the places where outer forces act on the effectors."""
        blocks = [measure.carrier[None, :, None] * np.eye(3)[:, None] for measure in self.measures]
        vectors = np.concatenate([np.zeros((0, 3)), *(block.reshape(-1, 3) for block in blocks)])
        counts = [3] * len(self)
        where = row_points(counts, self.starts)
        starts = self.starts.tolist()
        at = [
            measure.carrier @ placed.y[first:end]
            for measure, first, end in zip(self.measures, starts[:-1], starts[1:], strict=True)
        ]
        positions = np.concatenate([np.zeros(0), *at])
        return Rows(placed.rows(Entries(where.starts, where.points, vectors)), positions)


def row_points(rows: list[int], starts: Ints) -> Entries:
    """Which points the rows of each effector depend on: entries with vectors of zero."""
    ends = zip(rows, starts[:-1].tolist(), starts[1:].tolist(), strict=True)
    points = [np.tile(np.arange(first, end), count) for count, first, end in ends]
    sizes = np.repeat(np.diff(starts), rows)
    every = np.concatenate([np.zeros(0, np.int64), *points])
    return Entries(np.concatenate([[0], np.cumsum(sizes)]), every, np.zeros((len(every), 3)))
