"""Closest point of a triangle, the feature it lies on, and mean normals of edges and corners.

A triangle's features are numbered: 0 its interior, 1 + k the edge from corner k to corner k + 1,
4 + k the corner k.
"""

from __future__ import annotations

import numpy as np

from tauten.model.numerics import (
    Array,
    Ints,
    Vector3,
    add,
    cross,
    dot,
    kernel,
    row,
    scale,
    subtract,
    unit,
)

INTERIOR, EDGE, CORNER = 0, 1, 4  # first number of each kind of feature


@kernel
def ratio(part: float, rest: float) -> float:
    """The ratio part / (part + rest) of two non-negative numbers, 0 when both vanish."""
    return part / (part + rest) if part + rest > 0.0 else 0.0


@kernel
def closest(p: Vector3, a: Vector3, b: Vector3, c: Vector3) -> tuple[Vector3, int]:
    """Barycentric weights of the point of triangle abc closest to p, and the feature it lies on.

    Region by region (Ericson, Real-Time Collision Detection, 5.1.5); degenerate triangles are allowed.

    Args:
        p: the point [m].
        a: first corner [m].
        b: second corner [m].
        c: third corner [m].
    """
    ab, ac = subtract(b, a), subtract(c, a)
    ap, bp, cp = subtract(p, a), subtract(p, b), subtract(p, c)
    d1, d2 = dot(ab, ap), dot(ac, ap)
    if d1 <= 0.0 and d2 <= 0.0:
        return (1.0, 0.0, 0.0), CORNER
    d3, d4 = dot(ab, bp), dot(ac, bp)
    if d3 >= 0.0 and d4 <= d3:
        return (0.0, 1.0, 0.0), CORNER + 1
    vc = d1 * d4 - d3 * d2
    if vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        t = ratio(d1, -d3)
        return (1.0 - t, t, 0.0), EDGE
    d5, d6 = dot(ab, cp), dot(ac, cp)
    if d6 >= 0.0 and d5 <= d6:
        return (0.0, 0.0, 1.0), CORNER + 2
    vb = d5 * d2 - d1 * d6
    if vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        t = ratio(d2, -d6)
        return (1.0 - t, 0.0, t), EDGE + 2
    va = d3 * d6 - d5 * d4
    if va <= 0.0 and d4 >= d3 and d5 >= d6:
        t = ratio(d4 - d3, d5 - d6)
        return (0.0, 1.0 - t, t), EDGE + 1
    total = va + vb + vc
    if not total > 0.0:  # a sliver, for which rounding finds no region
        return (1.0, 0.0, 0.0), CORNER
    return (va / total, vb / total, vc / total), INTERIOR


@kernel
def combine(w: Vector3, a: Vector3, b: Vector3, c: Vector3) -> Vector3:
    """The point with barycentric weights w.

    Args:
        w: weights of the corners.
        a: first corner [m].
        b: second corner [m].
        c: third corner [m].
    """
    return add(add(scale(w[0], a), scale(w[1], b)), scale(w[2], c))


@kernel
def face_normal(x: Array, triangles: Ints, t: int) -> Vector3:
    """Unit normal of triangle t, zero when it is flat.

    Args:
        x: (n_nodes, 3) vertices [m].
        triangles: (f, 3) vertex ids.
        t: number of the triangle.
    """
    a = row(x, triangles[t, 0])
    ab = subtract(row(x, triangles[t, 1]), a)
    return unit(cross(ab, subtract(row(x, triangles[t, 2]), a)))


@kernel
def vertex_normal(
    x: Array, vertex: int, triangles: Ints, fans: Ints, begin: int, end: int
) -> Vector3:
    """Mean of the normals of the triangles around a vertex, weighted by their angles there.

    Args:
        x: (v, 3) vertex positions [m].
        vertex: its id.
        triangles: (t, 3) vertex ids.
        fans: triangles around vertices.
        begin: first entry of this vertex in `fans`.
        end: one past its last entry.
    """
    total = (0.0, 0.0, 0.0)
    for place in range(begin, end):
        t = fans[place]
        k = 0
        while triangles[t, k] != vertex:
            k += 1
        corner = row(x, vertex)
        following = unit(subtract(row(x, triangles[t, (k + 1) % 3]), corner))
        preceding = unit(subtract(row(x, triangles[t, (k + 2) % 3]), corner))
        angle = np.arccos(min(1.0, max(-1.0, dot(following, preceding))))
        total = add(total, scale(angle, face_normal(x, triangles, t)))
    return unit(total)


@kernel
def decreases_distance(r: Vector3, direction: Vector3) -> bool:
    """Whether a motion along `direction` decreases the distance to the point at r, beyond rounding."""
    slack = 1e-9
    product = dot(r, direction)
    return product > 0.0 and product * product > slack * slack * dot(r, r) * dot(
        direction, direction
    )


@kernel
def is_local_minimum(
    r: Vector3, x: Array, corner: int, triangles: Ints, fans: Ints, begin: int, end: int
) -> bool:
    """Whether no edge of the triangles around a corner leads closer to a point.

    Args:
        r: from the corner to the point [m].
        x: (v, 3) vertex positions [m].
        corner: id of the vertex.
        triangles: (t, 3) vertex ids.
        fans: triangles around vertices.
        begin: first entry of this corner in `fans`.
        end: one past its last entry.
    """
    at = row(x, corner)
    for place in range(begin, end):
        for k in range(3):
            if decreases_distance(r, subtract(row(x, triangles[fans[place], k]), at)):
                return False
    return True
