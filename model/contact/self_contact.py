"""Contact of a surface with itself: which of its parts are never compared, because material joins them.

A candidate and a triangle of the same surface are *neighbours*

- when the way between them along the surface is short: what lies there bends with the candidate, and the
  rule of the local minimum alone would let the two flanks at the root of a fold push each other apart;
- when the triangle lies behind the candidate, through a wall: there the sign of the gap has no meaning.

Both are measured at rest.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from tauten.model.mesh import unit_normals
from tauten.model.numerics import Array, Ints

EDGES_AWAY = 2.0  # neighbours along the surface, in mean edges
ALARM_EDGES = 0.5  # alarm distance, in mean edges
# Walls up to so many alarm distances thick are not compared with their other side
WALL_ALARMS = 4.0
TIE = 1e-6  # relative; what is in the plane of a candidate to rounding is a neighbour in any pose


def mean_edge(vertices: Array, triangles: Ints) -> float:
    """Mean length of the edges of a surface [m]."""
    ends = unique_edges(triangles)
    return float(np.linalg.norm(vertices[ends[:, 1]] - vertices[ends[:, 0]], axis=1).mean())


def unique_edges(triangles: Ints) -> Ints:
    """Each edge of a surface once: (e, 2) vertex ids."""
    edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    once: Ints = np.unique(edges, axis=0)
    return once


def neighbours_at_rest(
    vertices: Array, triangles: Ints, nodes: Ints, weights: Array, along: float, through: float
) -> Ints:
    """Numbers (k, 2) of candidates and triangles that are neighbours.

    Args:
        vertices: (v, 3) positions at rest [m].
        triangles: (t, 3) vertex ids of the surface, counter-clockwise seen from outside.
        nodes: (m, 3) vertices of the triangle each candidate lies in.
        weights: (m, 3) its barycentric weights.
        along: largest distance along the edges of the surface [m].
        through: largest distance through the body [m].
    """
    points = np.einsum("mj,mji->mi", weights, vertices[nodes])  # (m, 3)
    along, through = (1.0 + TIE) * along, (1.0 + TIE) * through
    near = _along_surface(vertices, triangles, nodes, points, along)
    behind = _through_wall(vertices, triangles, nodes, points, through)
    both: Ints = np.unique(np.vstack([near, behind]), axis=0)
    return both


def _along_surface(
    vertices: Array, triangles: Ints, nodes: Ints, points: Array, along: float
) -> Ints:
    """Neighbours along the surface, over the edges of the mesh: (k, 2)."""
    used, local = np.unique(triangles, return_inverse=True)
    local = local.reshape(-1, 3)
    ends = unique_edges(local.astype(np.int32))  # older graphs of scipy take no other integers
    length = np.linalg.norm(vertices[used[ends[:, 0]]] - vertices[used[ends[:, 1]]], axis=1)
    graph = sp.csr_array((length, (ends[:, 0], ends[:, 1])), shape=(len(used), len(used)))
    starts, start = np.unique(np.searchsorted(used, nodes), return_inverse=True)
    way = dijkstra(graph, directed=False, indices=starts, limit=along)  # (s, v)
    first = np.linalg.norm(points[:, None] - vertices[nodes], axis=2)  # (m, 3)
    reached = []
    for candidate, corners in enumerate(start.reshape(-1, 3)):
        distance = (first[candidate][:, None] + way[corners]).min(axis=0)  # (v,)
        close = np.flatnonzero((distance <= along)[local].any(axis=1))
        reached.append(np.stack([np.full(len(close), candidate), close], axis=1))
    return np.concatenate(reached).astype(np.int64)


def _through_wall(
    vertices: Array, triangles: Ints, nodes: Ints, points: Array, through: float
) -> Ints:
    """Triangles that lie behind a candidate and look away from it: (k, 2)."""
    corners = vertices[triangles]  # (t, 3, 3)
    centres = corners.mean(axis=1)
    radius = float(np.linalg.norm(corners - centres[:, None], axis=2).max())
    own = vertices[nodes]  # (m, 3, 3)
    normals = unit_normals(own)  # (m, 3)
    facing = unit_normals(corners)  # (t, 3)
    tie = TIE * (through + radius)
    found = cKDTree(centres).query_ball_point(points, through + radius)
    reached = []
    for candidate, close in enumerate(found):
        numbers = np.array(close, dtype=np.int64)
        away = corners[numbers] - points[candidate]  # (c, 3, 3)
        behind = (away @ normals[candidate] <= tie).all(axis=1)
        turned = np.einsum("cji,ci->cj", away, facing[numbers]).max(axis=1) >= -tie
        numbers = numbers[behind & turned]
        reached.append(np.stack([np.full(len(numbers), candidate), numbers], axis=1))
    return np.concatenate(reached).astype(np.int64)
