"""Triangles of a surface that cross each other, found in a tree of boxes.

The triangles are sorted along a Z-order curve (Morton 1966), so that neighbours in the order are neighbours
in space; each node of a binary tree over this order has the box around its triangles. Only pairs of nodes
whose boxes meet are divided further. Blocks of pairs are computed at once, the last one made first, so that
memory is bounded for any surface.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.mesh import ray_crossings
from tauten.model.numerics import Array, Bools, Ints
from tauten.service.process import Progress

BLOCK = 1 << 13  # pairs of nodes that are divided at once
BITS = 20  # of each coordinate along the curve


@dataclass(frozen=True, slots=True)
class _Tree:
    """Boxes of the nodes, level by level.

    Attributes:
        order: (t,) triangles along the curve.
        low, high: corners of the boxes of each level, (2^l, 3); where there is no triangle, +inf and −inf.
    """

    order: Ints
    low: tuple[Array, ...]
    high: tuple[Array, ...]


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
    tree = _tree(corners)
    leaves = len(tree.low) - 1
    # level, pairs of nodes (p, 2), and their share of the work; the last is divided first
    blocks: list[tuple[int, Ints, float]] = [(0, np.zeros((1, 2), dtype=np.int64), 1.0)]
    while blocks:
        level, pairs, share = blocks.pop()
        if level < leaves:
            level, pairs = level + 1, _divided(pairs)
            first, second = pairs.T
            low, high = tree.low[level], tree.high[level]
            meet = (low[first] <= high[second]) & (low[second] <= high[first])  # (p, 3)
            pairs = pairs[meet.all(axis=1)]
        if level == leaves:
            found = _crossing(corners, triangles, tree.order[pairs[pairs[:, 0] < pairs[:, 1]]])
            if found is not None:
                return found
        if level == leaves or not len(pairs):
            progress(share, "crossings of the surface")
            continue
        parts = np.array_split(pairs, -(-len(pairs) // BLOCK))
        blocks += [(level, part, share * len(part) / len(pairs)) for part in reversed(parts)]
    return None


def _tree(corners: Array) -> _Tree:
    """The tree over triangles with corners (t, 3, 3)."""
    low, high = corners.min(axis=1), corners.max(axis=1)  # (t, 3)
    middle = (low + high) / 2.0
    span = np.ptp(middle, axis=0)
    cells = (middle - middle.min(axis=0)) / np.where(span > 0.0, span, 1.0) * ((1 << BITS) - 1)
    order = np.argsort(_along_curve(cells.astype(np.int64)), kind="stable")
    size = 1 << max(len(corners) - 1, 0).bit_length()
    lows, highs = np.full((size, 3), np.inf), np.full((size, 3), -np.inf)
    lows[: len(order)], highs[: len(order)] = low[order], high[order]
    levels = [(lows, highs)]
    while len(lows) > 1:
        lows, highs = lows.reshape(-1, 2, 3).min(axis=1), highs.reshape(-1, 2, 3).max(axis=1)
        levels.append((lows, highs))
    levels.reverse()
    return _Tree(order, tuple(item[0] for item in levels), tuple(item[1] for item in levels))


def _along_curve(cells: Ints) -> Ints:
    """Place along the Z-order curve of cells (t, 3): their bits in turn."""
    place = np.zeros(len(cells), dtype=np.int64)
    for bit in range(BITS):
        for i in range(3):
            place |= ((cells[:, i] >> bit) & 1) << (3 * bit + i)
    return place


def _divided(pairs: Ints) -> Ints:
    """The pairs of children of pairs of nodes (p, 2), each once; a node is paired with itself too."""
    first, second = pairs.T
    children = [(0, 0), (0, 1), (1, 1), (1, 0)]
    made = np.concatenate([np.stack([2 * first + a, 2 * second + b], 1) for a, b in children])
    return made[made[:, 0] <= made[:, 1]]


def _crossing(corners: Array, triangles: Ints, pairs: Ints) -> tuple[int, int] | None:
    """The first of pairs of triangles (p, 2) that cross and share no vertex; None where there are none.

    Args:
        corners: (t, 3, 3).
        triangles: (t, 3) vertex ids.
        pairs: (p, 2) triangles whose boxes meet.
    """
    one, other = triangles[pairs[:, 0]], triangles[pairs[:, 1]]  # (p, 3)
    pairs = pairs[~(one[:, :, None] == other[:, None, :]).any(axis=(1, 2))]
    for part in np.array_split(pairs, -(-len(pairs) // BLOCK) or 1):
        a, b = corners[part[:, 0]], corners[part[:, 1]]  # (p, 3, 3)
        hit = pierced(a, b) | pierced(b, a)
        if hit.any():
            first, second = part[int(hit.argmax())]
            return int(first), int(second)
    return None


def pierced(edges_of: Array, through: Array) -> Bools:
    """Whether an edge of one triangle passes through another, pair by pair.

    Args:
        edges_of: (p, 3, 3) triangles whose edges are used.
        through: (p, 3, 3) triangles.
    """
    found = np.zeros(len(through), dtype=bool)
    for i in range(3):
        start = edges_of[:, i]
        u, v, t = ray_crossings(start, edges_of[:, (i + 1) % 3] - start, through)
        found |= (u > 0.0) & (v > 0.0) & (u + v < 1.0) & (t > 0.0) & (t < 1.0)
    return found
