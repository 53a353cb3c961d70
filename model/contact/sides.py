"""On which side of an obstacle or of another body candidates are: where they were at the start of the step.

A signed distance knows where a point is, not where it came from. A plate that moves by half of its thickness
in a step has candidates nearer to its far side then, and a fast part may have passed it. So where a candidate
meets an obstacle on its way through a step, the plane that touches the obstacle there is kept: at the end of
the step the candidate is to be before this plane. The way is that of the velocity at the start of the step,
relative to the obstacle as it moves, and straight in its frame. The first place on it is found by steps as
long as the distance that remains (conservative advancement; Mirtich, Impulse-based dynamic simulation of
rigid body systems, 1996), which needs nothing of a shape but its distance. Steps that detect contacts at
their start meet what is beyond the alarm distance there in the same way.

Of two bodies that move fast relative to each other, each candidate has the triangle of the other one that it
meets first, with vertices that move straight and evenly in the step. At its end the candidate is to be before
the plane of this triangle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from tauten.model.contact.closest_point import face_normal
from tauten.model.contact.obstacle import Obstacle, ObstaclePose
from tauten.model.numerics import (
    Array,
    Ints,
    Vector3,
    add,
    cross,
    dot,
    kernel,
    length,
    row,
    scale,
    subtract,
)

_Found: TypeAlias = tuple[Ints, Array, Array, Ints, Array]  # what detection writes

# Steps to the place where a candidate meets an obstacle; those that graze it need most
ADVANCES = 64
ROUNDING = 1e-9  # of depths
GRAZING = 0.05  # of the way of a candidate, depth at the end below which it has not met a triangle
BEHIND = 0.02  # of it, depth at the start that is rounding
BESIDE = 1e-9  # barycentric weight of a point that is on the edge of a triangle
# Cosine of the angle between normals from which on a contact is that with the triangle met
ALIKE = 0.5
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


@dataclass(frozen=True, slots=True)
class Hits:
    """Triangles that candidates of a pair meet first in a step.

    Attributes:
        place: (k,) numbers of these candidates in their pair.
        vertices: (k, 3) of the triangles.
        weights: (k, 3) of the points of the triangles that are met.
    """

    place: Ints
    vertices: Ints
    weights: Array


@kernel
def widen(box: Array, points: Array) -> None:
    """Make a box, lower and upper corner (2, 3), large enough for points (r, 3)."""
    for r in range(points.shape[0]):
        for i in range(3):
            box[0, i] = min(box[0, i], points[r, i])
            box[1, i] = max(box[1, i], points[r, i])


@kernel
def apart(one: Array, other: Array) -> bool:
    """Whether two boxes, lower and upper corners (2, 3), have no point in common."""
    found = False
    for i in range(3):
        found = found or not (one[0, i] <= other[1, i] and other[0, i] <= one[1, i])
    return found


@kernel
def swept(x: Array, end: Array, of: tuple[Ints, Array], numbers: Ints) -> Array:
    """Points of triangles at the start and at the end of a step: (r, 2, 3).

    Args:
        x: (v, 3) vertices at the start [m].
        end: (v, 3) at the end [m].
        of: vertices (m, 3) of triangles, and weights (m, 3) of a point of each.
        numbers: (r,) of these.
    """
    nodes, weights = of
    ways = np.zeros((len(numbers), 2, 3))
    for r in range(len(numbers)):
        for j in range(3):
            vertex, weight = nodes[numbers[r], j], weights[numbers[r], j]
            for i in range(3):
                ways[r, 0, i] += weight * x[vertex, i]
                ways[r, 1, i] += weight * end[vertex, i]
    return ways


@kernel
def boxes_around(x: Array, end: Array, triangles: Ints, numbers: Ints) -> Array:
    """Boxes around what triangles sweep in a step: (f, 2, 3), lower and upper corners.

    Args:
        x: (v, 3) vertices at the start [m].
        end: (v, 3) at the end [m].
        triangles: (t, 3) vertex ids.
        numbers: (f,) of some.
    """
    boxes = np.empty((len(numbers), 2, 3))
    boxes[:, 0], boxes[:, 1] = np.inf, -np.inf
    for f in range(len(numbers)):
        for j in range(3):
            vertex = triangles[numbers[f], j]
            widen(boxes[f], x[vertex : vertex + 1])
            widen(boxes[f], end[vertex : vertex + 1])
    return boxes


@kernel
def triangles_met(
    x: Array, end: Array, of_pair: tuple[Ints, Array, Ints], bodies: tuple[Ints, Ints]
) -> tuple[Ints, Ints, Array]:
    """The arrays of `Hits`, of candidates of one body and triangles of another one.

    What a candidate and a triangle sweep says whether they may meet, however slow they are.

    Args:
        x: (v, 3) vertices at the start of a step [m], and
        end: (v, 3) at its end, where nothing touches.
        of_pair: vertices (m, 3) and weights (m, 3) of its candidates, and its triangles (t, 3).
        bodies: numbers of the candidates (c,) and of the triangles (f,) that may meet.
    """
    (nodes, weights, triangles), (places, faces) = of_pair, bodies
    ways = swept(x, end, (nodes, weights), places)
    boxes = boxes_around(x, end, triangles, faces)
    every, own = np.empty((2, 3)), np.empty((2, 3))
    every[0], every[1] = np.inf, -np.inf
    widen(every, ways.reshape(-1, 3))
    near = [f for f in range(len(faces)) if not apart(boxes[f], every)]
    met, n = np.empty(len(places), np.int64), 0
    vertices, inside = np.empty((len(places), 3), np.int64), np.empty((len(places), 3))
    if len(near) == 0:
        return met[:0], vertices[:0], inside[:0]
    for c in range(len(places)):
        first = np.inf
        own[0], own[1] = np.inf, -np.inf
        widen(own, ways[c])
        for f in near:
            if apart(boxes[f], own):
                continue
            share, w = meeting(ways[c], x, end, triangles, faces[f])
            if share < first:
                first, met[n], vertices[n] = share, places[c], triangles[faces[f]]
                inside[n, 0], inside[n, 1], inside[n, 2] = w
        n += first < np.inf
    return met[:n], vertices[:n], inside[:n]


@kernel
def meeting(points: Array, x: Array, end: Array, triangles: Ints, t: int) -> tuple[float, Vector3]:
    """Share of a step after which a point passes a triangle inwards, +inf: not; weights of the place.

    Args:
        points: (2, 3) the point at the start and at the end [m].
        x: (v, 3) vertices at the start [m].
        end: (v, 3) at the end [m].
        triangles: (f, 3) vertex ids.
        t: number of the triangle.
    """
    never = (np.inf, (0.0, 0.0, 0.0))
    i, j, k = triangles[t, 0], triangles[t, 1], triangles[t, 2]
    a, b, c, to = row(x, i), row(x, j), row(x, k), (row(end, i), row(end, j), row(end, k))
    p, q = row(points, 0), row(points, 1)
    before = dot(face_normal(x, triangles, t), subtract(p, a))
    after = dot(face_normal(end, triangles, t), subtract(q, to[0]))
    way = length(subtract(subtract(q, p), subtract(to[0], a)))
    if not (before >= -BEHIND * way and after < -GRAZING * way):
        return never
    share = max(before, 0.0) / (max(before, 0.0) - after)
    p, a, b, c = (
        between(p, q, share),
        between(a, to[0], share),
        between(b, to[1], share),
        between(c, to[2], share),
    )
    along, across, away = subtract(b, a), subtract(c, a), subtract(p, a)
    normal = cross(along, across)
    square = dot(normal, normal)
    if not square > 0.0:
        return never
    w_b, w_c = dot(cross(away, across), normal) / square, dot(cross(along, away), normal) / square
    if min(1.0 - w_b - w_c, w_b, w_c) < -BESIDE:
        return never
    return share, (1.0 - w_b - w_c, w_b, w_c)


@kernel
def between(a: Vector3, b: Vector3, share: float) -> Vector3:
    """The point at a share of the way between two points.

    Args:
        a: from here.
        b: to here.
        share: of the way.
    """
    return (
        a[0] + share * (b[0] - a[0]),
        a[1] + share * (b[1] - a[1]),
        a[2] + share * (b[2] - a[2]),
    )


def hits_of(
    x: Array, end: Array, of_pair: tuple[Ints, Array, Ints], loose: Sequence[tuple[Ints, Ints]]
) -> Hits | None:
    """The triangles that candidates of a pair meet first in a step; None where none does.

    Args:
        x: (v, 3) vertices at its start [m].
        end: (v, 3) at its end, where nothing touches [m].
        of_pair: see `triangles_met`.
        loose: its bodies, see `ContactPair`.
    """
    found = [triangles_met(x, end, of_pair, bodies) for bodies in loose]
    place, vertices, weights = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return Hits(place, vertices, weights) if len(place) > 0 else None


@kernel
def add_hits(
    x: Array, hits: tuple[Ints, Ints, Array],
    pair: tuple[tuple[int, int, float], tuple[Ints, Array]], held: float, out: _Found, m: int,
) -> int:  # fmt: skip
    """Number of contacts after those with triangles that were met are written over or behind m others.

    A contact that was found stays where its normal is about that of the triangle, or it is deeper.

    Args:
        x: (v, 3) positions [m].
        hits: the arrays of `Hits`.
        pair: its number, first slot and friction; vertices (n, 3) of its candidates and their weights.
        held: distance at which surfaces are held [m].
        out: of `detect_all`.
        m: contacts in it.
    """
    (place, corners, inside), ((number, first, friction), (nodes, weights)) = hits, pair
    numbers, values, vectors, vertices, coefficients = out
    known = m
    for k in range(len(place)):
        s, gap = place[k], -held
        point, normal = (0.0, 0.0, 0.0), face_normal(x, corners, k)
        for j in range(3):
            point = add(point, scale(weights[s, j], row(x, nodes[s, j])))
            gap += weights[s, j] * dot(normal, row(x, nodes[s, j]))
            gap -= inside[k, j] * dot(normal, row(x, corners[k, j]))
        at = m
        for other in range(known):
            if numbers[0, other] == first + s:
                at = other
        if at < m and (dot(normal, row(vectors[1], at)) >= ALIKE or values[0, at] <= gap):
            continue
        numbers[0, at], numbers[1, at] = first + s, number
        values[0, at], values[1, at] = gap, friction
        for j in range(3):
            vectors[0, at, j], vectors[1, at, j] = point[j], normal[j]
            vertices[at, j], vertices[at, 3 + j] = nodes[s, j], corners[k, j]
            coefficients[at, j], coefficients[at, 3 + j] = weights[s, j], -inside[k, j]
        m = max(m, at + 1)
    return m
