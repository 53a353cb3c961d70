"""The effectors of a robot: functions of points of its body."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial
from typing import Generic, TypeVar

import numpy as np

from tauten.model.effectors.measure import Measure, Measurement, measurement_fault
from tauten.model.extension_error import answer_of
from tauten.model.numerics import Array, Ints
from tauten.model.points import Entries, Motion, OuterForces
from tauten.model.rows import EffectorRows, Rows
from tauten.model.signals import EffectorLayout

P_co = TypeVar("P_co", covariant=True)
Other = TypeVar("Other")


@dataclass(frozen=True)
class Effectors(Generic[P_co]):
    """Effectors in row order, over points of a body of type P_co (`tauten.model.points.Motion`).

    The points of a frame are its origin and columns of A of (E1): of tetrahedra the mean and moments of a
    region; of beams, for axis k, the difference of two points of the node, at the distance e_k and at the
    node itself, so that A is the node's rotation.

    Attributes:
        layout: kinds, weights, places of rows and values.
        measures: the effectors as functions of some of the points each.
        starts: (p + 1,) first point of each effector.
        points: of all effectors.
    """

    layout: EffectorLayout
    measures: tuple[Measure, ...]
    starts: Ints
    points: P_co

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
        """Every effector for positions y (P, 3) of the points [m].

        Raises:
            ExtensionError: the function of another package has failed, or gives no measurement.
        """
        starts, found = self.starts.tolist(), list[Measurement]()
        for i, (measure, first, end) in enumerate(
            zip(self.measures, starts[:-1], starts[1:], strict=True)
        ):
            added = self.layout.kinds[i] == "function"
            found.append(self._added(i, y[first:end]) if added else measure.at(y[first:end]))
        return found

    def _added(self, i: int, y: Array) -> Measurement:
        """Effector i, which is a function of another package, for positions y (P, 3) of its points [m]."""
        fault = partial(measurement_fault, P=len(y))
        return answer_of(f"effector {self.layout.names[i]!r}", fault, self.measures[i].at, y)

    def over(self, points: Other) -> Effectors[Other]:
        """The same effectors over points of another body."""
        return Effectors(self.layout, self.measures, self.starts, points)

    def positions(self, motion: Motion[P_co]) -> Array:
        """Positions (p, 3) of the effectors [m]."""
        y = motion.placed(self.points).y
        if self.one_point_each:
            return y
        return np.array([found.position for found in self.measured(y)])

    def values(self, motion: Motion[P_co]) -> Array:
        """Goal values (n_v,) of the effectors."""
        y = motion.placed(self.points).y
        if self.one_point_each:
            return y.ravel()
        return np.concatenate([found.values for found in self.measured(y)])

    def rows(self, motion: Motion[P_co]) -> EffectorRows:
        """Rows of the effectors."""
        placed = motion.placed(self.points)
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

    def pushed(self, forces: Array) -> OuterForces[P_co]:
        """Outer forces (3 p,) on the effectors as forces on the points [N]."""
        pairs = zip(self.measures, forces.reshape(-1, 3), strict=True)
        vectors = [np.outer(measure.carrier, force) for measure, force in pairs]
        return OuterForces(self.points, np.concatenate([np.zeros((0, 3)), *vectors]))

    def places(self, motion: Motion[P_co]) -> Rows:
        """Positions (3 p,) of the places where outer forces act on the effectors."""
        placed = motion.placed(self.points)
        blocks = [measure.carrier[None, :, None] * np.eye(3)[:, None] for measure in self.measures]
        vectors = np.concatenate([np.zeros((0, 3)), *(block.reshape(-1, 3) for block in blocks)])
        where, starts = row_points([3] * len(self), self.starts), self.starts.tolist()
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
