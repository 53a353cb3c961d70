"""Balls around groups of points: what is out of reach of a ball is out of reach of its points.

A contact surface has thousands of points of which a few are near an obstacle. Where the unknowns are few, as
in reduced robots, to place all of them is most of the work of finding these.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np

from tauten.model.numerics import Array, Bools, Ints, kernel
from tauten.model.points.entries import Placed

GROUP = 32  # points at most; a robot with fewer than two groups has no balls
ROUNDING = 1e-9  # of a radius, relative


@dataclass(frozen=True, slots=True, eq=False)
class Groups:
    """Points in groups, each of points near each other at rest.

    Attributes:
        order: (m,) the points, group after group.
        starts: (g + 1,) where each group starts in it.
    """

    order: Ints
    starts: Ints

    def largest(self, values: Array) -> Array:
        """The largest values (g, …) in each group, of values (m, …) of the points."""
        most: Array = np.maximum.reduceat(values[self.order], self.starts[:-1])
        return most

    def mean(self, values: Array) -> Array:
        """The mean (g, …) of each group, of values (m, …) of the points."""
        sizes = np.diff(self.starts).reshape(-1, *[1] * (values.ndim - 1))
        means: Array = np.add.reduceat(values[self.order], self.starts[:-1]) / sizes
        return means

    @property
    def owner(self) -> Ints:
        """The group of each point: (m,)."""
        owner = np.empty(len(self.order), np.int64)
        owner[self.order] = np.repeat(np.arange(len(self.starts) - 1), np.diff(self.starts))
        return owner


def groups_of(x: Array) -> Groups:
    """Points (m, 3) in groups of at most `GROUP`, halved across their longest side until they are."""
    parts, ready = [np.arange(len(x))], list[Ints]()
    while parts:
        part = parts.pop()
        if len(part) <= GROUP:
            ready.append(part)
            continue
        longest = np.ptp(x[part], axis=0).argmax()
        along, half = part[np.argsort(x[part, longest], kind="stable")], len(part) // 2
        parts += [along[half:], along[:half]]
    return Groups(np.concatenate(ready), np.cumsum([0, *map(len, ready)]))


class Balls(Protocol):
    """Balls around groups of points."""

    @property
    def groups(self) -> Groups:
        """The groups."""

    def at(self, motion: Any) -> tuple[Array, Array]:
        """Centres (g, 3) and radii (g,) [m] of balls that have the points of the groups inside.

        Args:
            motion: the state of the body that the points belong to.
        """


@runtime_checkable
class GroupedPoints(Protocol):
    """Points of a body that need not all be placed."""

    def balls(self, nodes: Ints, weights: Array) -> Balls | None:
        """Balls around combinations of the points; None: there are few, or they are placed at no cost.

        Args:
            nodes: (m, k) points of each combination.
            weights: (m, k) their weights.
        """

    def some_placed(self, motion: Any, chosen: Bools) -> Placed:
        """The points at a state, those that are not chosen (p,) at NaN.

        Args:
            motion: the state of the body.
            chosen: (p,) which are needed.
        """


@kernel
def near_points(
    distance: Array, radius: Array, reach: float, groups: tuple[Ints, Ints], nodes: Ints,
    placed: Bools,
) -> Ints:  # fmt: skip
    """Points whose balls are within reach (k,), ascending; what they are combinations of is marked.

    Args:
        distance: (g,) from the centres to what is to be in reach [m].
        radius: (g,) of the balls [m].
        reach: [m].
        groups: order (m,) and starts (g + 1,) of `Groups`.
        nodes: (m, k) of which points each is a combination.
        placed: (p,) these points, written to.
    """
    order, starts = groups
    near, count = np.zeros(len(order), np.bool_), 0
    for g in range(len(distance)):
        # written so that a ball at NaN is near
        if distance[g] - (1.0 + ROUNDING) * radius[g] >= (1.0 + ROUNDING) * reach:
            continue
        for place in range(starts[g], starts[g + 1]):
            near[order[place]] = True
        count += starts[g + 1] - starts[g]
    found, k = np.empty(count, np.int64), 0
    for i in range(len(near)):
        if near[i]:
            found[k] = i
            k += 1
            for j in range(nodes.shape[1]):
                placed[nodes[i, j]] = True
    return found
