"""The triangle each candidate stands over, and the signed gap and normal there.

The rule for what a candidate touches is in `tauten.model.contact`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from tauten.model.arrays import Array, Ints
from tauten.model.broad_phase import Grid, cell_of, make_grid, triangle_box
from tauten.model.closest import (
    CORNER,
    EDGE,
    INTERIOR,
    closest,
    face_normal,
    is_local_minimum,
    vertex_normal,
)
from tauten.model.jit import kernel
from tauten.model.patch import Patches
from tauten.model.vector import Vector3, add, dot, row, scale, subtract, unit

# Candidates this close to an edge or corner, relative to the alarm distance, are pushed along its
# mean normal: the direction from the surface is rounding there.
TOUCHING = 1e-7


class Feet(NamedTuple):
    """What each candidate stands over.

    Attributes:
        triangle: (m,) number in `Patches.triangles`, -1 without one.
        feature: (m,) its feature that is closest, see `tauten.model.closest`.
        weights: (m, 3) barycentric weights of the closest point.
        distance: (m,) to it [m].
    """

    triangle: Ints
    feature: Ints
    weights: Array
    distance: Array


@kernel
def no_feet(m: int, reach: float) -> Feet:
    """Feet of m candidates that stand over nothing within reach."""
    return Feet(
        np.full(m, -1, np.int64), np.zeros(m, np.int64), np.zeros((m, 3)), np.full(m, reach)
    )


@kernel
def corner_fan(patches: Patches, t: int, feature: int) -> Ints:
    """Triangles round the corner that a feature of triangle t is; none on the border."""
    k = feature - CORNER
    if k < 0 or patches.fan_first[t, k] < 0:
        return patches.fans[:0]
    return patches.fans[patches.fan_first[t, k] : patches.fan_last[t, k]]


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
    fan = corner_fan(patches, t, feature)
    opposite = patches.across[t, feature - EDGE] if feature < CORNER else -1
    if len(fan) == 0 and opposite < 0:
        return False
    return is_local_minimum(r, x, patches.triangles, t, feature, fan, opposite)


@kernel
def shares_vertex(a: Ints, b: Ints) -> bool:
    """Whether two triangles (3,), (3,) have a vertex in common."""
    for i in range(3):
        for j in range(3):
            if a[i] == b[j]:
                return True
    return False


@kernel
def search(x: Array, points: Array, own: Ints, patches: Patches, pair: int, reach: float) -> Feet:
    """The nearest triangle within reach that each candidate of one pair stands over.

    Args:
        x: (v, 3) vertex positions [m].
        points: (m, 3) the candidates [m]; one that is not finite finds nothing.
        own: (m, 3) vertices of their own triangles.
        patches: target surfaces.
        pair: which of the surfaces.
        reach: largest distance [m].
    """
    feet = no_feet(points.shape[0], reach)
    nearest = feet.distance
    grid = make_grid(points, reach)
    n_i, n_j, n_k = grid.shape
    for t in range(patches.first[pair], patches.first[pair + 1]):
        v = patches.triangles[t]
        a, b, c = row(x, v[0]), row(x, v[1]), row(x, v[2])
        low, high = triangle_box(a, b, c, reach)
        if not overlaps(grid, low, high):
            continue
        normal = face_normal(x, patches.triangles, t)
        k_low = cell_of(low[2], grid.lower[2], grid.size, n_k)
        k_high = cell_of(high[2], grid.lower[2], grid.size, n_k)
        i_high = cell_of(high[0], grid.lower[0], grid.size, n_i)
        j_high = cell_of(high[1], grid.lower[1], grid.size, n_j)
        for i in range(cell_of(low[0], grid.lower[0], grid.size, n_i), i_high + 1):
            for j in range(cell_of(low[1], grid.lower[1], grid.size, n_j), j_high + 1):
                line = (i * n_j + j) * n_k
                for place in range(grid.start[line + k_low], grid.start[line + k_high + 1]):
                    s = grid.order[place]
                    p = row(points, s)
                    if abs(dot(normal, subtract(p, a))) >= nearest[s]:
                        continue
                    w, feature = closest(p, a, b, c)
                    r = subtract(p, add(add(scale(w[0], a), scale(w[1], b)), scale(w[2], c)))
                    distance = dot(r, r) ** 0.5
                    if (
                        distance < nearest[s]
                        and not shares_vertex(own[s], v)
                        and stands_over(r, x, patches, t, feature)
                    ):
                        nearest[s], feet.triangle[s], feet.feature[s] = distance, t, feature
                        feet.weights[s, 0], feet.weights[s, 1], feet.weights[s, 2] = w
    return feet


@kernel
def overlaps(grid: Grid, low: Vector3, high: Vector3) -> bool:
    """Whether a box reaches into the box of the candidates; NaN does not."""
    apart = False
    for i in range(3):
        apart = apart or not (low[i] <= grid.upper[i] and high[i] >= grid.lower[i])
    return not apart


@kernel
def gap_and_normal(
    s: int, p: Vector3, x: Array, patches: Patches, feet: Feet, reach: float
) -> tuple[float, Vector3]:
    """Signed distance of candidate s at p to where it stands, and its gradient with respect to p.

    On edges and corners the mean normal gives the sign (Baerentzen and Aanaes 2005): that of both
    triangles, or of all round the corner weighted by their angles.
    """
    t, feature, w = feet.triangle[s], feet.feature[s], feet.weights[s]
    v = patches.triangles[t]
    a, b, c = row(x, v[0]), row(x, v[1]), row(x, v[2])
    r = subtract(p, add(add(scale(w[0], a), scale(w[1], b)), scale(w[2], c)))
    normal = face_normal(x, patches.triangles, t)
    if feature == INTERIOR:
        return dot(normal, r), normal
    if feature < CORNER:
        over = patches.over[t, feature - EDGE]
        normal = unit(add(normal, face_normal(x, patches.triangles, over)))
    else:
        fan = corner_fan(patches, t, feature)
        normal = vertex_normal(x, patches.triangles, fan, v[feature - CORNER])
    if feet.distance[s] < TOUCHING * reach:
        return dot(normal, r), normal
    sign = 1.0 if dot(normal, r) >= 0.0 else -1.0
    return sign * feet.distance[s], scale(sign / feet.distance[s], r)
