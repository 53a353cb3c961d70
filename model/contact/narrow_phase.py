"""The triangle each candidate stands over, and the signed gap and normal there.

The rule for what a candidate touches is in `tauten.model.contact.detection`. As a rule a
candidate stands over the
inside of the triangle with the smallest lower bound
(`tauten.model.contact.broad_phase`), which gives gap and normal
as well. Where it does not, the closest point is looked for on each triangle whose bound is below what was
found.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tauten.model.contact.broad_phase import ROUNDING, beyond, in_reach, lower_bound, rank, walls
from tauten.model.contact.closest_point import (
    CORNER,
    EDGE,
    INTERIOR,
    closest,
    combine,
    comes_closer,
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

# Candidates this close to an edge or corner, relative to the alarm distance, are pushed along its
# mean normal: the direction from the surface is rounding there.
TOUCHING = 1e-7


class ClosestPoints(NamedTuple):
    """What each candidate stands over; a tuple because kernels take it as it is.

    Attributes:
        triangle: (m,) number in `SurfaceTopology.triangles`, -1 without one.
        weights: (m, 3) barycentric weights of the closest point.
        gap: (m,) signed distance to it [m].
        normal: (m, 3) gradient of the gap with respect to the candidate.
    """

    triangle: Ints
    weights: Array
    gap: Array
    normal: Array


@kernel
def no_closest_points(m: int) -> ClosestPoints:
    """ClosestPoints of m candidates that stand over nothing."""
    return ClosestPoints(np.full(m, -1, np.int64), np.empty((m, 3)), np.empty(m), np.empty((m, 3)))


@kernel
def search(
    x: Array,
    points: Array,
    patches: SurfaceTopology,
    pair: int,
    begin: int,
    reach: float,
    feet: ClosestPoints,
) -> None:
    """The nearest triangle within reach that each of a block of candidates of one pair stands over.

    Args:
        x: (v, 3) vertex positions [m].
        points: (3, m) candidates begin … begin + m − 1 [m]; one that is not finite finds nothing.
        patches: target surfaces.
        pair: which of the surfaces.
        begin: number of the first candidate.
        reach: largest distance [m].
        feet: of all candidates, without triangles; overwritten.
    """
    near = in_reach(
        points, x, patches.triangles, patches.first[pair], patches.first[pair + 1], reach
    )
    planes = walls(x, patches.triangles, near)
    likely, next_best = rank(points, planes, near, patches, begin, reach)
    # tuples of arrays are taken apart here: handing them on costs more than what is done with them
    triangle, weights, gap, normal = feet.triangle, feet.weights, feet.gap, feet.normal
    for i in range(points.shape[1]):
        s, f, p = begin + i, likely[i], (points[0, i], points[1, i], points[2, i])
        if f < 0:
            continue
        height, a = beyond(p, planes, 0, f), beyond(p, planes, 4, f)
        b, c = beyond(p, planes, 8, f), beyond(p, planes, 12, f)
        inside = a < 0.0 and b < 0.0 and c < 0.0
        if inside and (1.0 + ROUNDING) * height * height <= next_best[i]:
            triangle[s], gap[s] = near[f], height
            weights[s, 2], weights[s, 0] = -a * planes[16, f], -b * planes[17, f]
            weights[s, 1] = 1.0 - weights[s, 2] - weights[s, 0]
            normal[s, 0], normal[s, 1], normal[s, 2] = planes[0, f], planes[1, f], planes[2, f]
        else:
            try_all(s, p, x, planes, near, patches, reach, feet)


@kernel
def try_all(
    s: int,
    p: Vector3,
    x: Array,
    planes: Array,
    near: Ints,
    patches: SurfaceTopology,
    reach: float,
    feet: ClosestPoints,
) -> None:
    """`search` for one candidate s at p, triangle by triangle."""
    triangles, square, place = patches.triangles, reach * reach, INTERIOR
    bounds = np.empty(near.shape[0])
    for f in range(near.shape[0]):
        bounds[f] = lower_bound(p, planes, f)
    for f in range(near.shape[0]):
        t = near[f]
        if not bounds[f] < (1.0 + ROUNDING) * square:
            continue
        if among(s, patches.kin, patches.kin_first[t], patches.kin_first[t + 1]):
            continue
        a, b, c = row(x, triangles[t, 0]), row(x, triangles[t, 1]), row(x, triangles[t, 2])
        w, feature = closest(p, a, b, c)
        r = subtract(p, combine(w, a, b, c))
        if dot(r, r) < square and stands_over(r, x, patches, t, feature):
            square, feet.triangle[s], place = dot(r, r), t, feature
            feet.weights[s, 0], feet.weights[s, 1], feet.weights[s, 2] = w
    if feet.triangle[s] >= 0:
        w = row(feet.weights, s)
        feet.gap[s], n = gap_and_normal(p, w, x, patches, feet.triangle[s], place, reach)
        feet.normal[s, 0], feet.normal[s, 1], feet.normal[s, 2] = n


@kernel
def among(s: int, members: Ints, begin: int, end: int) -> bool:
    """Whether s is one of members begin … end − 1."""
    found = False
    for place in range(begin, end):
        found = found or members[place] == s
    return found


@kernel
def stands_over(r: Vector3, x: Array, patches: SurfaceTopology, t: int, feature: int) -> bool:
    """Whether a triangle's closest point is inside the surface and faces the candidate.

    Args:
        r: from the closest point to the candidate.
        x: (v, 3) vertex positions [m].
        patches: target surfaces.
        t: the triangle.
        feature: its feature that is closest.
    """
    if feature == INTERIOR:
        return True
    if feature < CORNER:  # r is at right angles to the edge, so any of its points will do
        k = feature - EDGE
        across = patches.across[t, k]
        if across < 0:
            return False
        return not comes_closer(r, subtract(row(x, across), row(x, patches.triangles[t, k])))
    k = feature - CORNER
    begin, end = patches.fan_first[t, k], patches.fan_last[t, k]
    return begin >= 0 and is_local_minimum(
        r, x, patches.triangles[t, k], patches.triangles, patches.fans, begin, end
    )


@kernel
def gap_and_normal(
    p: Vector3, w: Vector3, x: Array, patches: SurfaceTopology, t: int, feature: int, reach: float
) -> tuple[float, Vector3]:
    """Signed distance of p to the point of triangle t with weights w, and its gradient with respect to p.

    On edges and corners the mean normal gives the sign (Baerentzen and Aanaes 2005): that of both
    triangles, or of all round the corner weighted by their angles.
    """
    triangles = patches.triangles
    a, b, c = row(x, triangles[t, 0]), row(x, triangles[t, 1]), row(x, triangles[t, 2])
    r = subtract(p, combine(w, a, b, c))
    normal = face_normal(x, triangles, t)
    if feature == INTERIOR:
        return dot(normal, r), normal
    if feature < CORNER:
        normal = unit(add(normal, face_normal(x, triangles, patches.over[t, feature - EDGE])))
    else:
        k = feature - CORNER
        begin, end = patches.fan_first[t, k], patches.fan_last[t, k]
        normal = vertex_normal(x, triangles[t, k], triangles, patches.fans, begin, end)
    distance = length(r)
    if distance < TOUCHING * reach:
        return dot(normal, r), normal
    sign = 1.0 if dot(normal, r) >= 0.0 else -1.0
    return sign * distance, scale(sign / distance, r)
