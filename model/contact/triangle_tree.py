"""Signed distance to a closed triangle surface that does not deform, by a tree of boxes and a grid of bounds.

The tree is a binary one of boxes along the axes, in the order of a depth-first walk, so that a query needs no
stack. A grid over the surface holds the signed distance of the centre of each of its cells, and the nearest
triangle there. A distance changes no faster than the point moves: most points that are out of reach are
known as such by their cell alone, and for others the cell's triangle gives a close first bound. Most of the
triangles whose boxes are within it are left out by their planes (`tauten.model.contact.broad_phase`).

Inside and outside are told apart by the mean normal of the feature that the nearest point lies on, weighted
by angles at corners (Baerentzen and Aanaes, Signed distance computation using the angle weighted
pseudonormal, IEEE Transactions on Visualization and Computer Graphics 11, 2005).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tauten.model.contact.broad_phase import bounding_planes
from tauten.model.contact.closest_point import closest, combine
from tauten.model.numerics import Array, Ints, Vector3, dot, kernel, length, row, scale, subtract

LEAF = 4  # triangles in a leaf at most
CELLS = 40_000  # of the grid, about
MARGIN = 1.5  # cells of the grid beyond the surface
ON_SURFACE = 1e-9  # of the size of the surface, within which the direction to a point is rounding


class TriangleTree(NamedTuple):
    """A closed surface for queries. A named tuple, because numba kernels take these as arguments.

    Attributes:
        corners: (t, 9) corners of the triangles in the order of the leaves [m].
        planes: (t, 16) normals and offsets of their planes and of those through their edges.
        normals: (t, 21) mean normals of their features, of length 1: interior, edges, corners, numbered as in
            `tauten.model.contact.closest_point`.
        boxes: (k, 6) least and largest coordinates of the nodes of the tree [m].
        links: (k, 3) the node after all that are below a node; first triangle of a leaf, and one past its
            last one, both zero of other nodes.
        lower: (3,) corner of the grid with the least coordinates [m].
        cell: (3,) edges of its cells [m].
        distance: (x, y, z) signed distance of the centres of the cells [m].
        nearest: (x, y, z) the triangle nearest to each.
        smallest: distance below which the mean normal is the direction [m].
    """

    corners: Array
    planes: Array
    normals: Array
    boxes: Array
    links: Ints
    lower: Array
    cell: Array
    distance: Array
    nearest: Ints
    smallest: float


def triangle_tree(vertices: Array, triangles: Ints) -> TriangleTree:
    """The tree of a closed surface (v, 3) [m], (t, 3), of triangles counter-clockwise seen from outside."""
    corners = vertices[triangles]  # (t, 3, 3)
    order, boxes, links = box_tree(corners.min(axis=1), corners.max(axis=1))
    corners = corners[order]
    normals = feature_normals(vertices, triangles)[order].reshape(-1, 21)
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    size = float(np.linalg.norm(high - low))
    edge = (np.prod(np.maximum(high - low, 0.02 * size)) / CELLS) ** (1.0 / 3.0)
    counts = np.ceil((high - low) / edge + 2.0 * MARGIN).astype(np.int64)  # (3,)
    lower = 0.5 * (low + high) - 0.5 * counts * edge
    planes = bounding_planes(vertices, triangles, order)[:16].T  # (t, 16)
    tree = TriangleTree(
        np.ascontiguousarray(corners.reshape(-1, 9)), np.ascontiguousarray(planes),
        np.ascontiguousarray(normals), boxes, links, lower, np.full(3, edge),
        np.full(counts, -np.inf), np.zeros(counts, np.int64), ON_SURFACE * size,
    )  # fmt: skip
    _fill_grid(tree)
    return tree


def feature_normals(vertices: Array, triangles: Ints) -> Array:
    """Mean normals (t, 7, 3) of length 1 at interior, edges and corners of triangles of a closed surface."""
    corners = vertices[triangles]  # (t, 3, 3)
    along = _units(
        np.roll(corners, -1, axis=1) - corners
    )  # (t, 3, 3), from each corner to the next
    face = _units(np.cross(along[:, 0], -along[:, 2]))  # (t, 3)
    angle = np.arccos(np.clip(-np.einsum("tki,tki->tk", along, np.roll(along, 1, axis=1)), -1, 1))
    at_corners = np.zeros_like(vertices)
    np.add.at(at_corners, triangles, angle[:, :, None] * face[:, None, :])
    edges = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2)  # (t, 3, 2)
    _, number = np.unique(np.sort(edges.reshape(-1, 2), axis=1), axis=0, return_inverse=True)
    at_edges = np.zeros((number.max() + 1, 3))
    np.add.at(at_edges, number.ravel(), np.repeat(face, 3, axis=0))
    found = [face[:, None], _units(at_edges[number.reshape(-1, 3)]), _units(at_corners)[triangles]]
    normals: Array = np.concatenate(found, axis=1)
    return normals


def _units(vectors: Array) -> Array:
    """Vectors (…, 3) of length 1; those without a length stay zero."""
    norm = np.linalg.norm(vectors, axis=-1, keepdims=True)
    found: Array = np.divide(vectors, norm, out=np.zeros_like(vectors), where=norm > 0.0)
    return found


@kernel
def box_tree(low: Array, high: Array) -> tuple[Ints, Array, Ints]:
    """A tree of triangles: their order (t,) by leaf, and `boxes` and `links` of `TriangleTree`.

    A node with more triangles than a leaf is divided at the median of their centres, along the axis in which
    these are spread most.

    Args:
        low: (t, 3) least coordinates of the triangles [m].
        high: (t, 3) their largest [m].
    """
    t = low.shape[0]
    order, most = np.arange(t), 2 * t + 1
    boxes, links = np.empty((most, 6)), np.zeros((most, 3), np.int64)
    # what is left to do: ranges of `order`; a node's number where it is to be closed
    begins, ends, closing = (
        np.empty(256, np.int64),
        np.empty(256, np.int64),
        np.empty(256, np.int64),
    )
    begins[0], ends[0], closing[0], left, count = 0, t, -1, 1, 0
    while left > 0:
        left -= 1
        if closing[left] >= 0:
            links[closing[left], 0] = count
            continue
        begin, stop, node = begins[left], ends[left], count
        count += 1
        axis, widest = 0, -1.0
        for i in range(3):
            least, largest, one, other = np.inf, -np.inf, np.inf, -np.inf
            for place in range(begin, stop):
                s = order[place]
                least, largest = min(least, low[s, i]), max(largest, high[s, i])
                centre = low[s, i] + high[s, i]
                one, other = min(one, centre), max(other, centre)
            boxes[node, i], boxes[node, 3 + i] = least, largest
            if other - one > widest:
                axis, widest = i, other - one
        if stop - begin <= LEAF:
            links[node, 0], links[node, 1], links[node, 2] = count, begin, stop
            continue
        part = order[begin:stop].copy()
        order[begin:stop] = part[np.argsort(low[part, axis] + high[part, axis])]
        middle = (begin + stop) // 2
        closing[left] = node
        begins[left + 1], ends[left + 1], closing[left + 1] = middle, stop, -1
        begins[left + 2], ends[left + 2], closing[left + 2] = begin, middle, -1
        left += 3
    return order, boxes[:count].copy(), links[:count].copy()


@kernel
def _fill_grid(tree: TriangleTree) -> None:
    """Write `distance` and `nearest` of a tree whose other arrays are made."""
    lower, cell, distance, nearest = tree.lower, tree.cell, tree.distance, tree.nearest
    last = 0
    for i in range(distance.shape[0]):
        for j in range(distance.shape[1]):
            for k in range(distance.shape[2]):
                p = (
                    lower[0] + (i + 0.5) * cell[0],
                    lower[1] + (j + 0.5) * cell[1],
                    lower[2] + (k + 0.5) * cell[2],
                )
                last, distance[i, j, k], _ = _nearest(
                    p, last, tree.corners, tree.planes, tree.normals, tree.boxes, tree.links,
                    tree.smallest,
                )  # fmt: skip
                nearest[i, j, k] = last


@kernel
def _nearest(
    p: Vector3,
    start: int,
    corners: Array,
    planes: Array,
    normals: Array,
    boxes: Array,
    links: Ints,
    smallest: float,
) -> tuple[int, float, Vector3]:
    """The triangle nearest to a point, the signed distance [m], and its gradient.

    Args:
        p: the point [m].
        start: a triangle that is probably near.
        corners: and the other arguments: of the tree; an argument each costs less than a tuple of them.
        planes: of triangles.
        normals: of features.
        boxes: of nodes.
        links: of nodes.
        smallest: distance below which the mean normal is the direction [m].
    """
    w, feature = closest(
        p, _corner(corners, start, 0), _corner(corners, start, 3), _corner(corners, start, 6)
    )
    best, r = start, _away(p, corners, start, w)
    square, node, count = dot(r, r), 0, boxes.shape[0]
    while node < count:
        x = max(max(boxes[node, 0] - p[0], p[0] - boxes[node, 3]), 0.0)
        y = max(max(boxes[node, 1] - p[1], p[1] - boxes[node, 4]), 0.0)
        z = max(max(boxes[node, 2] - p[2], p[2] - boxes[node, 5]), 0.0)
        if x * x + y * y + z * z >= square:
            node = links[node, 0]
            continue
        for s in range(links[node, 1], links[node, 2]):
            if s == start or _bound(p, planes, s) >= square:
                continue
            found, place = closest(
                p, _corner(corners, s, 0), _corner(corners, s, 3), _corner(corners, s, 6)
            )
            away = _away(p, corners, s, found)
            if dot(away, away) < square:
                square, best, feature, r = dot(away, away), s, place, away
        node += 1
    k = 3 * feature
    mean = (normals[best, k], normals[best, k + 1], normals[best, k + 2])
    distance, side = length(r), dot(mean, r)
    if distance <= smallest:
        return best, side, mean
    sign = 1.0 if side >= 0.0 else -1.0
    return best, sign * distance, scale(sign / distance, r)


@kernel
def _bound(p: Vector3, planes: Array, t: int) -> float:
    """Lower bound of the squared distance of p to triangle t [m²]."""
    height = planes[t, 0] * p[0] + planes[t, 1] * p[1] + planes[t, 2] * p[2] - planes[t, 3]
    a = planes[t, 4] * p[0] + planes[t, 5] * p[1] + planes[t, 6] * p[2] - planes[t, 7]
    b = planes[t, 8] * p[0] + planes[t, 9] * p[1] + planes[t, 10] * p[2] - planes[t, 11]
    c = planes[t, 12] * p[0] + planes[t, 13] * p[1] + planes[t, 14] * p[2] - planes[t, 15]
    out = max(max(a, b), max(c, 0.0))
    return float(height * height + out * out)


@kernel
def _corner(corners: Array, t: int, k: int) -> Vector3:
    """The corner of triangle t whose first coordinate is in column k."""
    return (corners[t, k], corners[t, k + 1], corners[t, k + 2])


@kernel
def _away(p: Vector3, corners: Array, t: int, w: Vector3) -> Vector3:
    """From the point with weights w of triangle t to the point p."""
    return subtract(
        p, combine(w, _corner(corners, t, 0), _corner(corners, t, 3), _corner(corners, t, 6))
    )


@kernel
def signed_distances(points: Array, tree: TriangleTree, reach: float) -> tuple[Array, Array]:
    """Signed distances (m,) of points [m], negative inside, and their gradients (m, 3).

    Points that are farther than `reach` outside the surface may have the distance +inf and no gradient.

    Args:
        points: (m, 3), finite [m].
        tree: of the surface.
        reach: distance up to which all are wanted [m].
    """
    m = points.shape[0]
    gap, normal = np.full(m, np.inf), np.zeros((m, 3))
    corners, planes, normals, boxes = tree.corners, tree.planes, tree.normals, tree.boxes
    links, lower, cell = tree.links, tree.lower, tree.cell
    distance, nearest, smallest = tree.distance, tree.nearest, tree.smallest
    high = (distance.shape[0] - 1, distance.shape[1] - 1, distance.shape[2] - 1)
    for s in range(m):
        p = row(points, s)
        # a cell far away is that of the border: clipped before it becomes a whole number
        i = int(min(max((p[0] - lower[0]) / cell[0], 0.0), float(high[0])))
        j = int(min(max((p[1] - lower[1]) / cell[1], 0.0), float(high[1])))
        k = int(min(max((p[2] - lower[2]) / cell[2], 0.0), float(high[2])))
        centre = (
            lower[0] + (i + 0.5) * cell[0],
            lower[1] + (j + 0.5) * cell[1],
            lower[2] + (k + 0.5) * cell[2],
        )
        if distance[i, j, k] - length(subtract(p, centre)) > reach:
            continue
        x = max(max(boxes[0, 0] - p[0], p[0] - boxes[0, 3]), 0.0)
        y = max(max(boxes[0, 1] - p[1], p[1] - boxes[0, 4]), 0.0)
        z = max(max(boxes[0, 2] - p[2], p[2] - boxes[0, 5]), 0.0)
        if x * x + y * y + z * z > reach * reach:
            continue
        _, gap[s], n = _nearest(
            p, nearest[i, j, k], corners, planes, normals, boxes, links, smallest
        )
        normal[s, 0], normal[s, 1], normal[s, 2] = n
    return gap, normal
