"""Closed surfaces among the boundary triangles of a body, for chambers.

The boundary of a body is oriented out of the material. A cavity is a connected closed part of it whose
volume, computed with this orientation, is negative.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from tauten.model.numerics import Array, Ints


class ChamberError(ValueError):
    """A surface that encloses no chamber; the text says why."""


def enclosed_volume(x: Array, triangles: Ints) -> float:
    """Signed volume [m³] of a closed surface (t, 3) of nodes x (n, 3), positive with normals out of it."""
    a, b, c = (x[triangles[:, i]] - x[triangles[0, 0]] for i in range(3))
    return float(np.einsum("ti,ti->", a, np.cross(b, c))) / 6.0


def inside_out(points: Array, triangles: Ints) -> bool:
    """Whether the normals of a closed surface (t, 3) of points (p, 3) point into what it encloses."""
    return enclosed_volume(points, triangles) < 0.0


def open_edges(triangles: Ints) -> Ints:
    """Edges (e, 2) that do not join exactly two triangles of the same orientation."""
    edges = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)  # directed
    ends, inverse = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True)
    inverse = inverse.ravel()
    forward = np.bincount(inverse, edges[:, 0] < edges[:, 1], minlength=len(ends))
    total = np.bincount(inverse, minlength=len(ends))
    found: Ints = ends[(forward != 1) | (total != 2)]
    return found


def chamber_surface(x: Array, triangles: Ints) -> Ints:
    """The surface of a chamber (t, 3), normals out of it, of boundary triangles (t, 3) of nodes x (n, 3) [m].

    Raises:
        ChamberError: the surface is not closed, or is around the body rather than within.
    """
    edges = open_edges(triangles)
    if len(edges):
        where = x[edges[0]].mean(axis=0).round(4).tolist()
        raise ChamberError(
            f"the surface of {len(triangles)} triangles is not closed: {len(edges)} edges, the first at "
            f"{where} m, do not join two triangles; select all triangles around the chamber"
        )
    if not enclosed_volume(x, triangles) < 0.0:
        raise ChamberError(
            f"the surface of {len(triangles)} triangles encloses the body from outside; select the inner "
            "surface of a cavity"
        )
    return np.ascontiguousarray(triangles[:, [0, 2, 1]])


def connected_parts(triangles: Ints) -> list[Ints]:
    """Parts (t, 3) of a surface that are connected by common nodes."""
    corners = triangles[:, [0, 1, 1, 2]].reshape(-1, 2)
    n = int(triangles.max(initial=0)) + 1
    graph = sp.coo_array((np.ones(len(corners)), (corners[:, 0], corners[:, 1])), shape=(n, n))
    _, label = connected_components(graph, directed=False)
    of_triangle = label[triangles[:, 0]]
    return [triangles[of_triangle == part] for part in np.unique(of_triangle)]


def cavities(x: Array, boundary: Ints) -> list[Ints]:
    """The inner parts (t, 3) of a boundary (t, 3) of nodes x (n, 3), with normals out of the material."""
    return [part for part in connected_parts(boundary) if enclosed_volume(x, part) < 0.0]


def cavity_around(x: Array, boundary: Ints, point: Array) -> Ints:
    """The cavity (t, 3) around a point, normals out of the material.

    Args:
        x: (n_nodes, 3) node positions [m].
        boundary: (t, 3) boundary triangles, normals out of the material.
        point: (3,) [m].

    Raises:
        ChamberError: the point is in no cavity.
    """
    found = cavities(x, boundary)
    around = [part for part in found if abs(winding(x, part, point)) > 0.5]
    if not around:
        raise ChamberError(
            f"the point {point.round(4).tolist()} m lies in none of the {len(found)} cavities of the mesh"
        )
    return min(around, key=len)


def winding(x: Array, triangles: Ints, point: Array) -> float:
    """How often a closed surface winds around a point (van Oosterom and Strackee, 1983).

    Args:
        x: (n_nodes, 3) node positions [m].
        triangles: (t, 3) nodes.
        point: (3,) [m].
    """
    a, b, c = (x[triangles[:, i]] - point for i in range(3))
    la, lb, lc = (np.linalg.norm(side, axis=1) for side in (a, b, c))
    triple = np.einsum("ti,ti->t", a, np.cross(b, c))
    dots = [np.einsum("ti,ti->t", *pair) for pair in ((a, b), (b, c), (c, a))]
    below = la * lb * lc + dots[0] * lc + dots[1] * la + dots[2] * lb
    return float(2.0 * np.arctan2(triple, below).sum()) / (4.0 * np.pi)


def cavity_nearest(x: Array, boundary: Ints, points: Array) -> Ints:
    """The cavity (t, 3) nearest to points of another surface, normals out of the material.

    Args:
        x: (n_nodes, 3) node positions [m].
        boundary: (t, 3) boundary triangles, normals out of the material.
        points: (p, 3) on the other surface [m].

    Raises:
        ChamberError: the mesh has no cavity, or none within a fifth of the size of the surface.
    """
    found = cavities(x, boundary)
    if not found:
        raise ChamberError("the mesh has no cavity: its boundary has no closed inner part")
    distance = [float(cKDTree(x[part].reshape(-1, 3)).query(points)[0].mean()) for part in found]
    best, size = int(np.argmin(distance)), float(np.linalg.norm(np.ptp(points, axis=0)))
    if not distance[best] < 0.2 * size:
        raise ChamberError(
            f"the nearest of {len(found)} cavities lies {distance[best]:.3g} m away from a surface of "
            f"{size:.3g} m: check its unit"
        )
    return found[best]
