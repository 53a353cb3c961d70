"""Triangles of a surface that cross each other, found in a tree of boxes."""

from __future__ import annotations

import numpy as np

from tauten.model.contact import apart, box_tree
from tauten.model.mesh import ray_crossings
from tauten.model.numerics import Array, Bools, Ints, kernel
from tauten.service.process import Progress

BLOCK = 1 << 12  # pairs that are looked at together, about: memory is bounded for any surface


def first_crossing(
    vertices: Array, triangles: Ints, progress: Progress = lambda share, what="": None
) -> tuple[int, int] | None:
    """Two triangles of a surface that cross each other and share no vertex; None where there are none.

    An edge of one has to pass through the other.

    Args:
        vertices: (v, 3).
        triangles: (t, 3).
        progress: called with the share of the work just done, and what is done.
    """
    corners = vertices[triangles]  # (t, 3, 3)
    boxes = np.stack([corners.min(axis=1), corners.max(axis=1)], axis=1)  # (t, 2, 3)
    order, around, links = box_tree(boxes[:, 0], boxes[:, 1])
    begin = 0
    while begin < len(triangles):
        pairs, end = meeting_pairs(begin, triangles, boxes, order, around.reshape(-1, 2, 3), links)
        a, b = corners[pairs[:, 0]], corners[pairs[:, 1]]  # (p, 3, 3)
        hit = pierced(a, b) | pierced(b, a)
        if hit.any():
            first, second = pairs[int(hit.argmax())].tolist()
            return first, second
        progress((end - begin) / len(triangles), "crossings of the surface")
        begin = end
    return None


@kernel
def meeting_pairs(
    begin: int, triangles: Ints, boxes: Array, order: Ints, around: Array, links: Ints
) -> tuple[Ints, int]:
    """Pairs (p, 2) of a triangle and a later one whose boxes meet and which share no vertex.

    Args:
        begin: the first triangle whose pairs are wanted.
        triangles: (t, 3) of the surface.
        boxes: (t, 2, 3) around them, lower and upper corners.
        order: (t,) and the other arguments: of their tree, see `box_tree`.
        around: (k, 2, 3) boxes of its nodes.
        links: (k, 3) of its nodes.

    Returns:
        The pairs of as many triangles as have `BLOCK` of them, and the triangle to begin with next.
    """
    t, n = len(triangles), 0
    found = np.empty((BLOCK + t, 2), np.int64)
    while begin < t and n < BLOCK:
        node = 0
        while node < len(links):
            if apart(boxes[begin], around[node]):
                node = links[node, 0]
                continue
            for place in range(links[node, 1], links[node, 2]):
                other = order[place]
                if other > begin and not apart(boxes[begin], boxes[other]):
                    shared = False
                    for i in range(3):
                        for j in range(3):
                            shared = shared or triangles[begin, i] == triangles[other, j]
                    if not shared:
                        found[n, 0], found[n, 1] = begin, other
                        n += 1
            node += 1
        begin += 1
    return found[:n].copy(), begin


def pierced(edges_of: Array, through: Array) -> Bools:
    """Whether an edge of one triangle passes through another, of pairs with corners (p, 3, 3): (p,)."""
    found = np.zeros(len(through), dtype=bool)
    for i in range(3):
        start = edges_of[:, i]
        u, v, t = ray_crossings(start, edges_of[:, (i + 1) % 3] - start, through)
        found |= (u > 0.0) & (v > 0.0) & (u + v < 1.0) & (t > 0.0) & (t < 1.0)
    return found
