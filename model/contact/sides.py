"""On which side of an obstacle candidates are: on that where they were at the start of the step.

A signed distance knows where a point is, not where it came from. A plate that moves by half of its thickness
in a step has candidates nearer to its far side then, and a fast part may have passed it. So where a candidate
meets an obstacle on its way through a step, the plane that touches the obstacle there is kept: at the end of
the step the candidate is to be before this plane. The way is that of the velocity at the start of the step,
relative to the obstacle as it moves, and straight in its frame. The first place on it is found by steps as
long as the distance that remains (conservative advancement; Mirtich, Impulse-based dynamic simulation of
rigid body systems, 1996), which needs nothing of a shape but its distance. Steps that detect contacts at
their start meet what is beyond the alarm distance there in the same way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tauten.model.contact.obstacle import Obstacle, ObstaclePose
from tauten.model.numerics import Array, Ints

ADVANCES = (
    64  # steps to the place where a candidate meets an obstacle; those that graze it need most
)
ROUNDING = 1e-9  # of depths
MET = 1e-3  # of the way of a candidate, distance at which it meets an obstacle


@dataclass(frozen=True, slots=True)
class Sides:
    """Where candidates of a pair meet its obstacle first in a step, in the frame of the obstacle.

    Attributes:
        place: (k,) numbers of these candidates in their pair.
        point: (k, 3) of the surface [m].
        normal: (k, 3) of the surface there.
    """

    place: Ints
    point: Array
    normal: Array

    def corrected(
        self, points: Array, pose: ObstaclePose, nearest: tuple[Array, Array], reach: float
    ) -> tuple[Array, Array]:
        """Distances (m,) [m], +inf out of reach, and normals (m, 3); of some to the side that they came from.

        These are the candidates that are behind the plane they are to be before, and nearer to another side
        of the obstacle or out of its reach.

        Args:
            points: (m, 3) the candidates of the pair [m].
            pose: of the obstacle.
            nearest: distances (m,) [m] and normals (m, 3) to the nearest points of the obstacle.
            reach: distance from which on a nearest point does not count [m].
        """
        gap, normal = nearest[0].copy(), nearest[1].copy()
        gap[~(gap < reach)] = np.inf
        own = (points[self.place] - pose.position) @ pose.Q
        side = self.normal @ pose.Q.T  # (k, 3)
        against = np.einsum("ki,ki->k", side, normal[self.place]) <= 0.0
        before = np.einsum("ki,ki->k", self.normal, own - self.point)  # (k,) negative behind planes
        deeper = before < gap[self.place] + ROUNDING * np.abs(before)  # halfway both are as deep
        wrong = (against | np.isinf(gap[self.place])) & deeper
        there = self.place[wrong]
        gap[there] = before[wrong]
        normal[there] = side[wrong]
        return gap, normal


def joined(several: Sequence[Sides]) -> Sides:
    """The first of several sides that each candidate has."""
    place, first = np.unique(np.concatenate([one.place for one in several]), return_index=True)
    point = np.concatenate([one.point for one in several])[first]
    return Sides(place, point, np.concatenate([one.normal for one in several])[first])


def sides_of(
    obstacle: Obstacle,
    before: tuple[Array, ObstaclePose],
    after: tuple[Array, ObstaclePose],
    reach: float = np.inf,
) -> Sides:
    """The candidates of a pair that meet its obstacle in a step, and would be on another side of it then.

    Args:
        obstacle: of the pair.
        before: candidates (m, 3) [m] and pose of the obstacle at the start of the step, and
        after: at its end, where nothing touches.
        reach: distance at the start from which on those count too that would be in the obstacle [m].
    """
    start, end = ((points - pose.position) @ pose.Q for points, pose in (before, after))
    way = end - start  # (m, 3)
    length = np.linalg.norm(way, axis=1)
    place = np.flatnonzero((length > 0.0) & (length < np.inf))
    if len(place) > 0:  # what crosses a surface ends within its way of it
        gap, there = obstacle.closest_own(end[place], 2.0 * float(length[place].max()))
        near = np.abs(gap) <= 2.0 * length[place]
        place, there, inside = place[near], there[near], gap[near] < 0.0
    if len(place) > 0:
        gap, here = obstacle.closest_own(start[place], 2.0 * float(length[place].max()))
        across = np.einsum("ki,ki->k", here, there) <= 0.0
        place = place[across | (inside & (gap >= reach))]
    point, way, length = start[place], way[place], length[place]
    share = np.zeros(len(place))
    met = np.zeros(len(place), np.bool_)
    surface, normals = np.empty((len(place), 3)), np.empty((len(place), 3))
    moving = np.arange(len(place))
    for _ in range(ADVANCES):
        if len(moving) == 0:
            break
        gap, normal = obstacle.closest_own(point[moving], 2.0 * float(length[moving].max()))
        there = gap <= MET * length[moving]
        now = moving[there]
        met[now], normals[now] = True, normal[there]
        surface[now] = point[now] - gap[there, None] * normal[there]
        moving, gap = moving[~there], gap[~there]
        share[moving] += gap / length[moving]
        moving = moving[share[moving] < 1.0]
        point[moving] = start[place[moving]] + share[moving, None] * way[moving]
    return Sides(place[met], surface[met], normals[met])
