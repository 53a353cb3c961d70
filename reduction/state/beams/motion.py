"""Motion of points attached to a tree of beams, and rows over them, in reduced coordinates."""

from __future__ import annotations

import numpy as np

from tauten.model.numerics import Array, Ints, cross, kernel, row


@kernel
def point_motion(nodes: Ints, weights: Array, arms: Array, J: Array) -> Array:
    """Motion of attached points in reduced coordinates: (3 p, r).

    Args:
        nodes: (p, 2) nodes of the points.
        weights: (p, 2) their weights.
        arms: (p, 2, 3) weighted lever arms [m].
        J: (6 n_nodes, r) from `follow`.
    """
    moved = np.zeros((3 * nodes.shape[0], J.shape[1]))
    for p in range(nodes.shape[0]):
        for side in range(2):
            w, n, at = weights[p, side], 6 * nodes[p, side], 3 * p
            if w == 0.0:
                continue
            r0, r1, r2 = row(arms[p], side)
            for j in range(J.shape[1]):
                w0, w1, w2 = J[n + 3, j], J[n + 4, j], J[n + 5, j]
                moved[at, j] += w * J[n, j] + (w1 * r2 - w2 * r1)
                moved[at + 1, j] += w * J[n + 1, j] + (w2 * r0 - w0 * r2)
                moved[at + 2, j] += w * J[n + 2, j] + (w0 * r1 - w1 * r0)
    return moved


@kernel
def point_rows(
    starts: Ints,
    points: Ints,
    vectors: Array,
    nodes: Ints,
    weights: Array,
    arms: Array,
    J: Array,
) -> Array:
    """Rows over points (`tauten.model.points.Entries`) in reduced coordinates: (m, r).

    Args:
        starts: (m + 1,) where each row's entries start.
        points: (e,) point of each entry.
        vectors: (e, 3) vector of each entry.
        nodes: (p, 2) nodes of the points.
        weights: (p, 2) their weights.
        arms: (p, 2, 3) weighted lever arms [m].
        J: (6 n_nodes, r) from `follow`.
    """
    m, r = starts.shape[0] - 1, J.shape[1]
    H = np.zeros((m, r))
    used, wrench = np.empty(64, np.int64), np.empty((64, 6))
    for i in range(m):
        count = 0
        for e in range(starts[i], starts[i + 1]):
            p, f = points[e], row(vectors, e)
            for side in range(2):
                w = weights[p, side]
                if w == 0.0:
                    continue
                at, node = 0, nodes[p, side]
                while at < count and used[at] != node:
                    at += 1
                if at == used.shape[0]:  # full: what is there goes into the row
                    add_wrenches(used, wrench, count, J, H[i])
                    at, count = 0, 0
                if at == count:
                    used[at], count = node, count + 1
                    wrench[at] = 0.0
                moment = cross(row(arms[p], side), f)
                for k in range(3):
                    wrench[at, k] += w * f[k]
                    wrench[at, 3 + k] += moment[k]
        add_wrenches(used, wrench, count, J, H[i])
    return H


@kernel
def add_wrenches(used: Ints, wrench: Array, count: int, J: Array, H: Array) -> None:
    """Add the power of forces and moments on nodes to a row.

    Args:
        used: node numbers.
        wrench: (…, 6) force and moment on each of them.
        count: how many.
        J: (6 n_nodes, r) from `follow`.
        H: (r,) accumulated.
    """
    for at in range(count):
        n = 6 * used[at]
        f0, f1, f2 = wrench[at, 0], wrench[at, 1], wrench[at, 2]
        m0, m1, m2 = wrench[at, 3], wrench[at, 4], wrench[at, 5]
        for j in range(J.shape[1]):
            change = f0 * J[n, j] + f1 * J[n + 1, j] + f2 * J[n + 2, j]
            change += m0 * J[n + 3, j] + m1 * J[n + 4, j] + m2 * J[n + 5, j]
            H[j] += change
