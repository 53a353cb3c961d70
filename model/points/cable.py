"""Cables that slide through points of a body of tetrahedra, and their curvature.

Lengths and rows are those of `tauten.model.points.paths`. Since H_a turns with the body, a tension adds
λ_a ∂²L/∂q² to the tangent: positive semidefinite, as L is convex, and negative semidefinite in a rod that
pushes.
"""

from __future__ import annotations

import numpy as np

from tauten.model.numerics import Array, Ints, kernel
from tauten.model.points.nodes import NodePoints
from tauten.model.points.paths import Paths, Segments, blunted


def segment_nodes(paths: Paths, stations: NodePoints) -> Ints:
    """Nodes of both ends of every segment (s, 8); an end that does not move has those of the other one."""
    first, nodes = paths.first, stations.nodes
    moves = (stations.weights != 0.0).any(axis=1)[:, None]  # (p, 1)
    start = np.where(moves[first], nodes[first], nodes[first + 1])
    return np.concatenate([start, np.where(moves[first + 1], nodes[first + 1], start)], axis=1)


def segment_weights(paths: Paths, stations: NodePoints) -> Array:
    """Their weights, those of the first end negated: (s, 8)."""
    first, weights = paths.first, stations.weights
    return np.concatenate([-weights[first], weights[first + 1]], axis=1)


@kernel
def add_cable_stiffness(
    y: Array,
    segments: Segments,
    weights: Array,
    effort: Array,
    blocks: tuple[Ints, Ints],
    K: Array,
) -> None:
    """Add λ_a ∂²L/∂q² of every segment to a tangent.

    Args:
        y: (p, 3) stations [m].
        segments: see `Paths.segment_arrays`; the second station is the next.
        weights: (s, 8) of the nodes of both ends, negative for the first end.
        effort: (n_a,) [N].
        blocks: slot (s, 8, 8) and column_length (s, 8), see `Pattern.blocks`.
        K: (nnz,) CSC values of −∂force, added to.
    """
    first, owner, shortest = segments
    slot, column_length = blocks
    d = np.empty(3)
    for s in range(owner.shape[0]):
        force = effort[owner[s]]
        for i in range(3):
            d[i] = y[first[s] + 1, i] - y[first[s], i]
        ell = np.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
        if force == 0.0:
            continue
        _, slope, curvature = blunted(ell, shortest[s])
        along = (curvature - slope) / (ell * ell) if ell > 0.0 else 0.0
        for a in range(8):
            for b in range(8):
                w = force * weights[s, a] * weights[s, b]
                if slot[s, a, b] < 0 or w == 0.0:
                    continue
                for j in range(3):
                    for i in range(3):
                        part = along * d[i] * d[j]
                        if i == j:
                            part += slope
                        K[slot[s, a, b] + j * column_length[s, b] + i] += w * part
