"""Narrow phase: the contact point of each candidate, with its signed gap and normal.

The rule for the contact point is in `tauten.model.contact.detection`. Usually it lies in the interior of
the triangle with the smallest lower bound (`tauten.model.contact.broad_phase`), whose planes then give gap
and normal as well. Otherwise the closest point is computed on each triangle whose bound is below the
distance found so far.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tauten.model.contact.broad_phase import (
    ROUNDING,
    bounding_planes,
    in_reach,
    lower_bound,
    plane_distance,
    rank,
)
from tauten.model.contact.closest_point import (
    CORNER,
    EDGE,
    INTERIOR,
    closest,
    combine,
    decreases_distance,
    face_normal,
    is_local_minimum,
    vertex_normal,
)
from tauten.model.contact.surface_topology import SurfaceTopology
from tauten.model.numerics import (
    Array,
    Ints,
    Vector3,
    add,
    dot,
    kernel,
    length,
    row,
    scale,
    subtract,
    unit,
)

# Candidates this close to an edge or corner, relative to the alarm distance, get its mean normal: the
# direction from the contact point to the candidate is only rounding error there.
TOUCHING = 1e-7


class ClosestPoints(NamedTuple):
    """The contact point of each candidate. A named tuple, because numba kernels take these as arguments.

    Attributes:
        triangle: (m,) number in `SurfaceTopology.triangles`, −1 where there is no contact point.
        weights: (m, 3) its barycentric weights.
        gap: (m,) signed distance to it [m].
        normal: (m, 3) gradient of the gap with respect to the candidate.
    """

    triangle: Ints
    weights: Array
    gap: Array
    normal: Array


@kernel
def no_closest_points(m: int) -> ClosestPoints:
    """`ClosestPoints` of m candidates without a contact point."""
    return ClosestPoints(np.full(m, -1, np.int64), np.empty((m, 3)), np.empty(m), np.empty((m, 3)))


@kernel
def search(
    x: Array,
    points: Array,
    surfaces: SurfaceTopology,
    pair: int,
    begin: int,
    reach: float,
    found: ClosestPoints,
) -> None:
    """Find the contact points of a block of candidates of one pair.

    Args:
        x: (v, 3) vertex positions [m].
        points: (3, m) candidates begin … begin + m − 1 [m]; one that is not finite has no contact point.
        surfaces: target surfaces.
        pair: which of the surfaces.
        begin: number of the first candidate.
        reach: largest distance [m].
        found: of the block, without contact points yet; written to.
    """
    near = in_reach(
        points, x, surfaces.triangles, surfaces.first[pair], surfaces.first[pair + 1], reach
    )
    planes = bounding_planes(x, surfaces.triangles, near)
    likely, next_best = rank(points, planes, near, surfaces, begin, reach)
    # the arrays of the tuple are unpacked here, because passing the tuple on costs more than the work
    triangle, weights, gap, normal = found.triangle, found.weights, found.gap, found.normal
    for i in range(points.shape[1]):
        f, p = likely[i], (points[0, i], points[1, i], points[2, i])
        if f < 0:
            continue
        height, a = plane_distance(p, planes, 0, f), plane_distance(p, planes, 4, f)
        b, c = plane_distance(p, planes, 8, f), plane_distance(p, planes, 12, f)
        inside = a < 0.0 and b < 0.0 and c < 0.0
        if inside and (1.0 + ROUNDING) * height * height <= next_best[i]:
            triangle[i], gap[i] = near[f], height
            weights[i, 2], weights[i, 0] = -a * planes[16, f], -b * planes[17, f]
            weights[i, 1] = 1.0 - weights[i, 2] - weights[i, 0]
            normal[i, 0], normal[i, 1], normal[i, 2] = planes[0, f], planes[1, f], planes[2, f]
        else:
            search_all((begin + i, i), p, x, planes, near, surfaces, reach, found)


@kernel
def search_all(
    place: tuple[int, int],
    p: Vector3,
    x: Array,
    planes: Array,
    near: Ints,
    surfaces: SurfaceTopology,
    reach: float,
    found: ClosestPoints,
) -> None:
    """Find the contact point of one candidate by comparing all triangles in reach.

    Args:
        place: number of the candidate, and where it is in `found`.
        p: its position [m].
        x: (v, 3) vertex positions [m].
        planes: of the triangles in reach, see `bounding_planes`.
        near: (t,) their numbers.
        surfaces: target surfaces.
        reach: largest distance [m].
        found: of the block; written to.
    """
    (number, i), nearest = place, INTERIOR
    triangles, square = surfaces.triangles, reach * reach
    bounds = np.empty(near.shape[0])
    for f in range(near.shape[0]):
        bounds[f] = lower_bound(p, planes, f)
    for f in range(near.shape[0]):
        t = near[f]
        if not bounds[f] < (1.0 + ROUNDING) * square:
            continue
        first, end = surfaces.adjacent_first[t], surfaces.adjacent_first[t + 1]
        if among(number, surfaces.adjacent, first, end):
            continue
        a, b, c = row(x, triangles[t, 0]), row(x, triangles[t, 1]), row(x, triangles[t, 2])
        w, feature = closest(p, a, b, c)
        r = subtract(p, combine(w, a, b, c))
        if dot(r, r) < square and is_admissible(r, x, surfaces, t, feature):
            square, found.triangle[i], nearest = dot(r, r), t, feature
            found.weights[i, 0], found.weights[i, 1], found.weights[i, 2] = w
    if found.triangle[i] >= 0:
        w = row(found.weights, i)
        found.gap[i], n = gap_and_normal(p, w, x, surfaces, found.triangle[i], nearest, reach)
        found.normal[i, 0], found.normal[i, 1], found.normal[i, 2] = n


@kernel
def among(s: int, members: Ints, begin: int, end: int) -> bool:
    """Whether s is one of members begin … end − 1.

    Args:
        s: the number to find.
        members: (m,) numbers.
        begin: first place of `members` that counts.
        end: place after the last.
    """
    found = False
    for place in range(begin, end):
        found = found or members[place] == s
    return found


@kernel
def is_admissible(r: Vector3, x: Array, surfaces: SurfaceTopology, t: int, feature: int) -> bool:
    """Whether a triangle's closest point lies inside the surface and is a local minimum of the distance.

    Args:
        r: from the closest point to the candidate [m].
        x: (v, 3) vertex positions [m].
        surfaces: target surfaces.
        t: the triangle.
        feature: its feature that the closest point lies on.
    """
    if feature == INTERIOR:
        return True
    if feature < CORNER:  # r is perpendicular to the edge, so any of its points can be used
        k = feature - EDGE
        opposite = surfaces.opposite[t, k]
        if opposite < 0:
            return False
        edge = row(x, surfaces.triangles[t, k])
        return not decreases_distance(r, subtract(row(x, opposite), edge))
    k = feature - CORNER
    begin, end = surfaces.fan_first[t, k], surfaces.fan_last[t, k]
    return begin >= 0 and is_local_minimum(
        r, x, surfaces.triangles[t, k], surfaces.triangles, surfaces.fans, begin, end
    )


@kernel
def gap_and_normal(
    p: Vector3, w: Vector3, x: Array, surfaces: SurfaceTopology, t: int, feature: int, reach: float
) -> tuple[float, Vector3]:
    """Signed distance [m] of p to a point of a triangle, and its gradient with respect to p.

    On edges and corners the mean normal gives the sign (Baerentzen and Aanaes 2005): that of both
    triangles, or of all around the corner weighted by their angles.

    Args:
        p: position of the candidate [m].
        w: barycentric weights of the point.
        x: (v, 3) vertex positions [m].
        surfaces: target surfaces.
        t: the triangle.
        feature: its feature that the point lies on.
        reach: alarm distance [m].
    """
    triangles = surfaces.triangles
    a, b, c = row(x, triangles[t, 0]), row(x, triangles[t, 1]), row(x, triangles[t, 2])
    r = subtract(p, combine(w, a, b, c))
    normal = face_normal(x, triangles, t)
    if feature == INTERIOR:
        return dot(normal, r), normal
    if feature < CORNER:
        normal = unit(add(normal, face_normal(x, triangles, surfaces.neighbour[t, feature - EDGE])))
    else:
        k = feature - CORNER
        begin, end = surfaces.fan_first[t, k], surfaces.fan_last[t, k]
        normal = vertex_normal(x, triangles[t, k], triangles, surfaces.fans, begin, end)
    distance = length(r)
    if distance < TOUCHING * reach:
        return dot(normal, r), normal
    sign = 1.0 if dot(normal, r) >= 0.0 else -1.0
    return sign * distance, scale(sign / distance, r)
