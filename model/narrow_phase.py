"""The triangle each candidate stands over, and the signed gap and normal there.

The rule for what a candidate touches is in `tauten.model.contact`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tauten.model.arrays import Array, Ints
from tauten.model.broad_phase import cell_of, make_grid, triangle_box
from tauten.model.closest import (
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
from tauten.model.jit import kernel
from tauten.model.patch import Patches
from tauten.model.vector import Vector3, add, dot, length, row, scale, subtract, unit

# Candidates this close to an edge or corner, relative to the alarm distance, are pushed along its
# mean normal: the direction from the surface is rounding there.
TOUCHING = 1e-7


class Feet(NamedTuple):
    """What each candidate stands over; a tuple because kernels take it as it is.

    Attributes:
        triangle: (m,) number in `Patches.triangles`, -1 without one.
        feature: (m,) its feature that is closest, see `tauten.model.closest`.
        weights: (m, 3) barycentric weights of the closest point.
    """

    triangle: Ints
    feature: Ints
    weights: Array


@kernel
def no_feet(m: int) -> Feet:
    """Feet of m candidates that stand over nothing."""
    return Feet(np.full(m, -1, np.int64), np.zeros(m, np.int64), np.zeros((m, 3)))


@kernel
def stands_over(r: Vector3, x: Array, patches: Patches, t: int, feature: int) -> bool:
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
def shares_vertex(own: Ints, s: int, triangles: Ints, t: int) -> bool:
    """Whether row s of own (m, 3) and row t of triangles (t, 3) have a vertex in common."""
    for i in range(3):
        for j in range(3):
            if own[s, i] == triangles[t, j]:
                return True
    return False


@kernel
def search(
    x: Array, points: Array, own: Ints, patches: Patches, pair: int, reach: float, last: Ints
) -> Feet:
    """The nearest triangle within reach that each candidate of one pair stands over.

    Args:
        x: (v, 3) vertex positions [m].
        points: (m, 3) the candidates [m]; one that is not finite finds nothing.
        own: (m, 3) vertices of their own triangles.
        patches: target surfaces.
        pair: which of the surfaces.
        reach: largest distance [m].
        last: (m,) triangle of the surface that each stood over last time, −1 for none; it saves time and
            changes nothing.
    """
    feet = no_feet(points.shape[0])
    grid = make_grid(points, reach)
    triangles, start, lower, size = patches.triangles, grid.start, grid.lower, grid.size
    # tuples of arrays are taken apart here: handing them on costs more than many a test they are for
    n_i, n_j, n_k = grid.shape
    points_by_cell, order, upper = grid.points, grid.order, grid.upper
    nearest = bounds(x, points_by_cell, order, own, triangles, reach, last)
    for t in range(patches.first[pair], patches.first[pair + 1]):
        a, b, c = row(x, triangles[t, 0]), row(x, triangles[t, 1]), row(x, triangles[t, 2])
        low, high = triangle_box(a, b, c, reach)
        if not overlaps(lower, upper, low, high):
            continue
        normal = face_normal(x, triangles, t)
        centre, radius = circumscribed(a, b, c)
        k_low, k_end = (
            cell_of(low[2], lower[2], size, n_k),
            cell_of(high[2], lower[2], size, n_k) + 1,
        )
        j_low, j_end = (
            cell_of(low[1], lower[1], size, n_j),
            cell_of(high[1], lower[1], size, n_j) + 1,
        )
        i_low, i_end = (
            cell_of(low[0], lower[0], size, n_i),
            cell_of(high[0], lower[0], size, n_i) + 1,
        )
        for i in range(i_low, i_end):
            for j in range(j_low, j_end):
                line = (i * n_j + j) * n_k
                for place in range(start[line + k_low], start[line + k_end]):
                    p = row(points_by_cell, place)
                    d, far = subtract(p, centre), radius + nearest[place]
                    if dot(d, d) >= far * far or abs(dot(normal, d)) >= nearest[place]:
                        continue
                    w, feature = closest(p, a, b, c)
                    r = subtract(p, combine(w, a, b, c))
                    s, distance = order[place], length(r)
                    if (
                        distance < nearest[place]
                        and not shares_vertex(own, s, triangles, t)
                        and stands_over(r, x, patches, t, feature)
                    ):
                        nearest[place], feet.triangle[s], feet.feature[s] = distance, t, feature
                        feet.weights[s, 0], feet.weights[s, 1], feet.weights[s, 2] = w
    return feet


@kernel
def bounds(
    x: Array, points: Array, order: Ints, own: Ints, triangles: Ints, reach: float, last: Ints
) -> Array:
    """Distances (f,) within which each point has its nearest triangle, from the one found last time.

    A hair more than the distance to that one where the point still stands over its inside, else the reach.
    """
    nearest = np.full(points.shape[0], reach)
    for place in range(points.shape[0]):
        s = order[place]
        t = last[s]
        if t < 0:
            continue
        a, b, c = row(x, triangles[t, 0]), row(x, triangles[t, 1]), row(x, triangles[t, 2])
        p = row(points, place)
        w, feature = closest(p, a, b, c)
        if feature == INTERIOR and not shares_vertex(own, s, triangles, t):
            distance = length(subtract(p, combine(w, a, b, c)))
            nearest[place] = min(reach, (1.0 + 1e-9) * distance + 1e-12 * reach)
    return nearest


@kernel
def circumscribed(a: Vector3, b: Vector3, c: Vector3) -> tuple[Vector3, float]:
    """The centroid of a triangle and its distance to the farthest corner."""
    centre = scale(1.0 / 3.0, add(add(a, b), c))
    radius = max(length(subtract(a, centre)), length(subtract(b, centre)))
    return centre, max(radius, length(subtract(c, centre)))


@kernel
def overlaps(lower: Array, upper: Array, low: Vector3, high: Vector3) -> bool:
    """Whether a box reaches into that of the candidates, lower (3,) to upper (3,); NaN does not."""
    apart = False
    for i in range(3):
        apart = apart or not (low[i] <= upper[i] and high[i] >= lower[i])
    return not apart


@kernel
def gap_and_normal(
    s: int, p: Vector3, x: Array, patches: Patches, feet: Feet, reach: float
) -> tuple[float, Vector3]:
    """Signed distance of candidate s at p to where it stands, and its gradient with respect to p.

    On edges and corners the mean normal gives the sign (Baerentzen and Aanaes 2005): that of both
    triangles, or of all round the corner weighted by their angles.
    """
    t, feature, triangles = feet.triangle[s], feet.feature[s], patches.triangles
    a, b, c = row(x, triangles[t, 0]), row(x, triangles[t, 1]), row(x, triangles[t, 2])
    r = subtract(p, combine(row(feet.weights, s), a, b, c))
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
