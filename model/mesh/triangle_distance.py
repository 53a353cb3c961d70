"""Distance of points to triangles."""

from __future__ import annotations

import numpy as np

from tauten.model.numerics import Array, kernel


@kernel
def distances_to_triangles(points: Array, corners: Array) -> Array:
    """Distance of each point to the nearest triangle: (m,) [m].

    Ericson, Real-Time Collision Detection, 2005, 5.1.5.

    Args:
        points: (m, 3) [m].
        corners: (t, 3, 3) corners of the triangles [m].
    """
    result = np.empty(points.shape[0])
    for i in range(points.shape[0]):
        best = np.inf
        for t in range(corners.shape[0]):
            best = min(best, squared_distance(points[i], corners[t]))
        result[i] = np.sqrt(best)
    return result


@kernel
def squared_distance(p: Array, corners: Array) -> float:
    """Square of the distance of a point p (3,) to a triangle (3, 3) [m²]."""
    a, ab, ac = corners[0], corners[1] - corners[0], corners[2] - corners[0]
    ap = p - a
    g00, g01, g11 = np.dot(ab, ab), np.dot(ab, ac), np.dot(ac, ac)
    d0, d1 = np.dot(ab, ap), np.dot(ac, ap)
    area = g00 * g11 - g01 * g01
    if area > 0.0:
        s, t = (g11 * d0 - g01 * d1) / area, (g00 * d1 - g01 * d0) / area
        if s >= 0.0 and t >= 0.0 and s + t <= 1.0:
            r = ap - s * ab - t * ac
            return float(np.dot(r, r))
    best: float = np.inf
    for i in range(3):  # otherwise the nearest point lies on an edge
        start, edge = corners[i], corners[(i + 1) % 3] - corners[i]
        length = np.dot(edge, edge)
        share = 0.0
        if length > 0.0:
            share = min(max(np.dot(p - start, edge) / length, 0.0), 1.0)
        r = p - start - share * edge
        best = min(best, float(np.dot(r, r)))
    return best
