"""Rows of contact gaps between surfaces that are fixed to the nodes of beams."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tauten.model.contact import Detection
from tauten.model.numerics import Array, Ints, cross, kernel, row
from tauten.model.points import AttachedPoints


def gap_arrays(
    found: Detection, points: AttachedPoints, arms: Array, dof: Ints
) -> tuple[NDArray[np.int32], NDArray[np.int32], Array]:
    """Row starts, columns and data of the gaps over the motion of nodes (T2).

    Args:
        found: contacts in range, between triangles of attached points.
        points: the points.
        arms: (p, 2, 3) their lever arms, from `place`.
        dof: (n_nodes,) first degree of freedom of a node, −1 where it is fixed.
    """
    return gap_rows(
        found.vertices, found.coefficients, found.normal, points.nodes, points.weights, arms, dof
    )


@kernel
def gap_rows(
    vertices: Ints,
    coefficients: Array,
    normal: Array,
    nodes: Ints,
    weights: Array,
    arms: Array,
    dof: Ints,
) -> tuple[NDArray[np.int32], NDArray[np.int32], Array]:
    """`gap_arrays`; a node occurs once in a row.

    Args:
        vertices: (m, 6) as in `Detection`.
        coefficients: (m, 6) as in `Detection`.
        normal: (m, 3) as in `Detection`.
        nodes: (p, 2) nodes of the points.
        weights: (p, 2) their weights.
        arms: (p, 2, 3) weighted lever arms [m].
        dof: (n_nodes,) first degree of freedom of a node, −1 where it is fixed.
    """
    m, end = vertices.shape[0], 0
    most = 12 if (weights[:, 1] != 0.0).any() else 6
    data, columns = np.empty(6 * most * m), np.empty(6 * most * m, np.int32)
    starts = np.zeros(m + 1, np.int32)
    used, sums = np.empty(12, np.int64), np.empty((12, 4))
    for k in range(m):
        n, count = row(normal, k), 0
        for j in range(6):
            p, c = vertices[k, j], coefficients[k, j]
            count = add_point(nodes[p], weights[p], arms[p], c, dof, used, sums, count)
        for at in range(count):
            moment = cross((sums[at, 1], sums[at, 2], sums[at, 3]), n)
            for i in range(3):
                columns[end + i], columns[end + 3 + i] = used[at] + i, used[at] + 3 + i
                data[end + i], data[end + 3 + i] = sums[at, 0] * n[i], moment[i]
            end += 6
        starts[k + 1] = end
    return starts, columns[:end], data[:end]


@kernel
def add_point(
    nodes: Ints,
    weights: Array,
    arms: Array,
    factor: float,
    dof: Ints,
    used: Ints,
    sums: Array,
    count: int,
) -> int:
    """Add a multiple of a point to the sums over its nodes; returns how many nodes there are then.

    Args:
        nodes: (2,) of the point.
        weights: (2,) theirs.
        arms: (2, 3) weighted lever arms [m].
        factor: of the point.
        dof: (n_nodes,) first degree of freedom of a node, −1 where it is fixed.
        used: (12,) first degrees of freedom of the nodes so far.
        sums: (12, 4) their weight and lever arm.
        count: how many.
    """
    for side in range(2):
        w, first = weights[side], dof[nodes[side]]
        if w == 0.0 or first < 0:
            continue
        at = 0
        while at < count and used[at] != first:
            at += 1
        if at == count:
            used[at], count = first, count + 1
            sums[at] = 0.0
        sums[at, 0] += factor * w
        for i in range(3):
            sums[at, 1 + i] += factor * arms[side, i]
    return count
