"""Broad phase: the triangle of a surface that is probably the nearest, for each of a block of candidates.

The planes of a triangle and of its edges give a lower bound of the distance to it, which is exact for
points over its interior and beside its edges. Triangles out of reach of the whole block are left out; the
bounds of the others are computed in loops over flat arrays, which the compiler vectorises.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from tauten.model.contact.closest_point import face_normal
from tauten.model.contact.surface_topology import SurfaceTopology
from tauten.model.numerics import Array, Ints, Vector3, cross, dot, kernel, row, subtract, unit

BLOCK = 128  # candidates treated together
SHORT = 16  # candidates; blocks of connected parts have at least as many
ROUNDING = 1e-9  # of bounds, relative


def blocks_of(candidates: list[Ints], n_vertices: int) -> Ints:
    """Candidates that are treated together: (b, 3) first slot, one past the last, and the pair.

    Those of each pair are given by the vertices (m, 3) of the triangles that they lie in. A block ends with
    its pair, after `BLOCK` candidates, and, where it has `SHORT`, with the connected part of the surface that
    it lies in: few triangles are within reach of a block that is small in space.
    """
    blocks, begin = [], 0
    for pair, nodes in enumerate(candidates):
        links = np.concatenate([nodes[:, :2], nodes[:, 1:]])
        graph = sp.coo_array((np.ones(len(links)), links.T), shape=(n_vertices, n_vertices))
        part = connected_components(graph, directed=False)[1][nodes[:, 0]]
        start = begin
        for i in range(1, len(nodes) + 1):
            size = begin + i - start
            ends = i == len(nodes) or (part[i] != part[i - 1] and size >= SHORT)
            if ends or size == BLOCK:
                blocks.append((start, begin + i, pair))
                start = begin + i
        begin += len(nodes)
    return np.array(blocks, dtype=np.int64).reshape(-1, 3)


@kernel
def in_reach(points: Array, x: Array, triangles: Ints, first: int, end: int, reach: float) -> Ints:
    """Triangles that may be within reach of a point: those whose box is within reach of the points' box.

    Args:
        points: (3, m) the points [m]; those that are not finite are ignored.
        x: (v, 3) vertex positions [m].
        triangles: (t, 3) vertex ids.
        first: first triangle of the surface.
        end: one past its last triangle.
        reach: largest distance [m].
    """
    lower, upper = box(points)
    near, count = np.empty(end - first, np.int64), 0
    for t in range(first, end):
        apart = False
        for i in range(3):
            a, b, c = x[triangles[t, 0], i], x[triangles[t, 1], i], x[triangles[t, 2], i]
            # written so that a box with NaN is apart from everything
            meets = min(a, b, c) - reach <= upper[i] and max(a, b, c) + reach >= lower[i]
            apart = apart or not meets
        if not apart:
            near[count] = t
            count += 1
    return near[:count]


@kernel
def box(points: Array) -> tuple[Array, Array]:
    """Corners (3,) of the box around the finite ones of points (3, m); +inf and −inf without any."""
    lower, upper = np.full(3, np.inf), np.full(3, -np.inf)
    for i in range(3):
        for s in range(points.shape[1]):
            if abs(points[i, s]) < np.inf:
                lower[i], upper[i] = min(lower[i], points[i, s]), max(upper[i], points[i, s])
    return lower, upper


@kernel
def rank(
    points: Array, planes: Array, near: Ints, surfaces: SurfaceTopology, begin: int, reach: float
) -> tuple[Ints, Array]:
    """The triangle of the smallest lower bound for each candidate, and the second smallest bound.

    Args:
        points: (3, m) candidates begin … begin + m − 1 [m].
        planes: of the triangles, see `bounding_planes`.
        near: (t,) their numbers.
        surfaces: target surfaces; a candidate is not compared with the triangles it is adjacent to.
        begin: number of the first candidate.
        reach: largest distance [m].

    Returns:
        (m,) index into `near`, −1 when none is within reach; (m,) squared bound [m²], +inf without a second
        one.
    """
    m = points.shape[1]
    X, Y, Z = points[0], points[1], points[2]
    likely, least = np.full(m, -1, np.int64), np.full(m, reach * reach)
    second, bounds = np.full(m, np.inf), np.empty(m)
    for f in range(near.shape[0]):
        lower_bounds(X, Y, Z, planes, f, bounds)
        for place in range(surfaces.adjacent_first[near[f]], surfaces.adjacent_first[near[f] + 1]):
            if 0 <= surfaces.adjacent[place] - begin < m:
                bounds[surfaces.adjacent[place] - begin] = np.inf
        update_smallest(f, bounds, likely, least, second)
    return likely, second


@kernel
def lower_bounds(X: Array, Y: Array, Z: Array, planes: Array, f: int, bounds: Array) -> None:
    """`lower_bound` of points with coordinates (m,) into bounds (m,).

    Args:
        X: (m,) x coordinates [m].
        Y: (m,) y coordinates [m].
        Z: (m,) z coordinates [m].
        planes: (18, t) of `bounding_planes`.
        f: column of the triangle.
        bounds: (m,) output [m²].
    """
    n0, n1, n2, n3 = planes[0, f], planes[1, f], planes[2, f], planes[3, f]
    a0, a1, a2, a3 = planes[4, f], planes[5, f], planes[6, f], planes[7, f]
    b0, b1, b2, b3 = planes[8, f], planes[9, f], planes[10, f], planes[11, f]
    c0, c1, c2, c3 = planes[12, f], planes[13, f], planes[14, f], planes[15, f]
    for s in range(X.shape[0]):
        height = n0 * X[s] + n1 * Y[s] + n2 * Z[s] - n3
        a = a0 * X[s] + a1 * Y[s] + a2 * Z[s] - a3
        b = b0 * X[s] + b1 * Y[s] + b2 * Z[s] - b3
        c = c0 * X[s] + c1 * Y[s] + c2 * Z[s] - c3
        out = a if a > b else b
        out = c if c > out else out
        out = out if out > 0.0 else 0.0
        bounds[s] = height * height + out * out


@kernel
def update_smallest(f: int, bounds: Array, likely: Ints, least: Array, second: Array) -> None:
    """Update the smallest two bounds of each point with those of triangle f, all (m,).

    Args:
        f: number of the triangle.
        bounds: (m,) lower bounds for it [m²].
        likely: (m,) triangle of the smallest bound, overwritten.
        least: (m,) smallest bound, overwritten [m²].
        second: (m,) second smallest bound, overwritten [m²].
    """
    for s in range(least.shape[0]):
        bound, smallest, following = bounds[s], least[s], second[s]
        closer = bound < smallest
        larger = smallest if closer else bound
        second[s] = larger if larger < following else following
        least[s] = bound if closer else smallest
        likely[s] = f if closer else likely[s]


@kernel
def lower_bound(p: Vector3, planes: Array, f: int) -> float:
    """Lower bound of the squared distance of p to triangle f of `bounding_planes`.

    Args:
        p: the point [m].
        planes: (18, t) of `bounding_planes`.
        f: column of the triangle.
    """
    height, a = plane_distance(p, planes, 0, f), plane_distance(p, planes, 4, f)
    b, c = plane_distance(p, planes, 8, f), plane_distance(p, planes, 12, f)
    out = a if a > b else b
    out = c if c > out else out
    out = out if out > 0.0 else 0.0
    return float(height * height + out * out)


@kernel
def plane_distance(p: Vector3, planes: Array, k: int, f: int) -> float:
    """Signed distance [m] of p from the plane in rows k to k + 3 of triangle f.

    Args:
        p: the point [m].
        planes: (18, t) of `bounding_planes`.
        k: first of the four rows of the plane.
        f: column of the triangle.
    """
    along = planes[k, f] * p[0] + planes[k + 1, f] * p[1] + planes[k + 2, f] * p[2]
    return float(along - planes[k + 3, f])


@kernel
def bounding_planes(x: Array, triangles: Ints, near: Ints) -> Array:
    """Planes that bound the triangles numbered `near` (t,): (18, t).

    Rows 0 to 3: unit normal and offset of the triangle's plane. Rows 4 to 15: the same of the three planes
    through its edges, perpendicular to it, with normals that point outward. Rows 16 and 17: one over the
    distances of the first two edges to the corners opposite them [1/m].

    Args:
        x: (n_nodes, 3) vertices [m].
        triangles: (f, 3) vertex ids.
        near: (t,) numbers of the triangles.
    """
    planes = np.empty((18, near.shape[0]))
    for f in range(near.shape[0]):
        t = near[f]
        n, corner = face_normal(x, triangles, t), row(x, triangles[t, 0])
        put_plane(planes, 0, f, n, corner)
        for k in range(3):
            following = row(x, triangles[t, (k + 1) % 3])
            put_plane(planes, 4 + 4 * k, f, unit(cross(subtract(following, corner), n)), corner)
            if k < 2:
                high = -plane_distance(row(x, triangles[t, (k + 2) % 3]), planes, 4 + 4 * k, f)
                planes[16 + k, f] = 1.0 / high if high > 0.0 else np.inf
            corner = following
    return planes


@kernel
def put_plane(planes: Array, k: int, f: int, n: Vector3, p: Vector3) -> None:
    """Write the plane through p with normal n into rows k to k + 3 of triangle f.

    Args:
        planes: (18, t) of `bounding_planes`, overwritten.
        k: first of the four rows of the plane.
        f: column of the triangle.
        n: unit normal.
        p: a point of the plane [m].
    """
    planes[k, f], planes[k + 1, f], planes[k + 2, f] = n
    planes[k + 3, f] = dot(n, p)
