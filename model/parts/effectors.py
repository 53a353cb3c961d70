"""The effectors of several parts, each a function of points of its own part."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tauten.model.effectors import Effectors, Measure, Measurement
from tauten.model.numerics import Array, joined
from tauten.model.parts.motion import PartsPoints, PointsOfPart
from tauten.model.parts.part import Part, Placement
from tauten.model.signals import EffectorLayout


@dataclass(frozen=True, slots=True, eq=False)
class PlacedMeasure:
    """An effector of a part, its position and rotation in the robot's frame; a `Measure`.

    It is computed in the part's own frame, so that whatever an effector does there it does wherever the part
    stands. The rotation of a frame is the one from rest, about axes of the robot's frame.
    """

    own: Measure
    placement: Placement

    @property
    def carrier(self) -> Array:
        """Weights (P,) of its points in the place where outer forces act on it."""
        return self.own.carrier

    def at(self, y: Array) -> Measurement:
        """The effector for positions y (P, 3) of its points in the part's frame."""
        found, place = self.own.at(y), self.placement
        values, delta, gradient = found.values.copy(), found.delta.copy(), found.gradient.copy()
        if len(delta) >= 3:
            values[:3], delta[:3] = place.points(values[:3]), place.points(delta[:3])
        if len(values) == 7:  # q and Q q Qᵀ differ in the axis alone
            values[4:] = place.vectors(values[4:])
        for first in range(0, len(delta) - 2, 3):  # position, rotation
            rows = slice(first, first + 3)
            gradient[rows] = np.einsum("ij,jpk->ipk", place.Q, found.gradient[rows])
        return Measurement(values, delta, place.points(found.position), gradient)


def parts_effectors(parts: Sequence[Part]) -> Effectors[PartsPoints]:
    """The effectors of all parts in one list, named by part and effector."""
    groups: list[PointsOfPart] = []
    measures: list[Measure] = []
    starts, layouts, names, count = [np.zeros(1, np.int64)], [], [], 0
    for number, part in enumerate(parts):
        effectors = part.robot.effectors
        points_only = effectors.layout.positions_only
        groups.append(
            PointsOfPart(
                number, effectors.points, part.placement.elsewhere if points_only else None
            )
        )
        measures += [
            measure if points_only else PlacedMeasure(measure, part.placement)
            for measure in effectors.measures
        ]
        starts.append(effectors.starts[1:] + count)
        count += int(effectors.starts[-1])
        layouts.append(effectors.layout)
        names += [part.named(name) for name in effectors.layout.names]
    layout: EffectorLayout = replace(joined(layouts), names=tuple(names))
    points = PartsPoints(tuple(groups))
    return Effectors(layout, tuple(measures), np.concatenate(starts), points)
