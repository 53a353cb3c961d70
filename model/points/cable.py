"""Cables that slide through points of a body of tetrahedra, and their curvature.

Lengths and rows are those of `tauten.model.points.paths`. Since H_a turns with the body, a tension adds
λ_a ∂²L/∂q² to the tangent: positive semidefinite, as L is convex, and negative semidefinite in a rod that
pushes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.numerics import Array, Ints, kernel
from tauten.model.points.entries import PlacedOnNodes
from tauten.model.points.material_points import MaterialPoints
from tauten.model.points.paths import Paths, Segments, blunted, make_paths


@dataclass(frozen=True, slots=True)
class Cable:
    """A cable through material points, the last one its end.

    Attributes:
        name: in messages.
        points: material points it slides through, in order.
        pull_point: (3,) fixed point it is pulled from [m]; None: pulled from its first point.
    """

    name: str
    points: MaterialPoints
    pull_point: Array | None


@dataclass(frozen=True, slots=True)
class CableSet:
    """All cables of a robot made of tetrahedra.

    Attributes:
        paths: through the stations.
        nodes: (p, 4) nodes of the stations.
        weights: (p, 4) their weights; zero where a station does not move.
        fixed: (p, 3) position of what does not move in a station [m].
        segment_nodes: (s, 8) nodes of both ends of every segment.
        segment_weights: (s, 8) their weights, those of the first end negated.
    """

    paths: Paths
    nodes: Ints
    weights: Array
    fixed: Array
    segment_nodes: Ints
    segment_weights: Array

    @property
    def n_a(self) -> int:
        """Number of cables."""
        return self.paths.n_a

    def stations(self, x: Array) -> Array:
        """Positions of the stations (p, 3) at node positions x (n_nodes, 3) [m]."""
        return combined(x, self.nodes, self.weights, self.fixed)

    def placed(self, x: Array, dof: Ints, n: int) -> PlacedOnNodes:
        """The stations at one state.

        Args:
            x: (n_nodes, 3) node positions [m].
            dof: (n_nodes,) first degree of freedom of a node, −1 where it is fixed.
            n: number of degrees of freedom.
        """
        return PlacedOnNodes(self.stations(x), self.nodes, self.weights, dof, n)


def make_cables(cables: list[Cable], x0: Array) -> CableSet:
    """Arrays of the cables, rest lengths measured at node positions x0 (n_nodes, 3)."""
    none = np.zeros((0, 4), dtype=np.int64)
    nodes, weights, fixed, counts = [none], [np.zeros((0, 4))], [np.zeros((0, 3))], []
    for cable in cables:
        own = cable.points
        if cable.pull_point is not None:
            nodes.append(own.nodes[:1])
            weights.append(np.zeros((1, 4)))
            fixed.append(np.asarray(cable.pull_point, dtype=float)[None])
        nodes.append(own.nodes)
        weights.append(own.weights)
        fixed.append(np.zeros((len(own), 3)))
        counts.append(len(own) + (cable.pull_point is not None))
    joined = np.concatenate(nodes), np.concatenate(weights), np.concatenate(fixed)
    paths = make_paths(counts, combined(x0, *joined))
    first, second = paths.first, paths.first + 1
    return CableSet(
        paths,
        *joined,
        segment_nodes=np.concatenate([joined[0][first], joined[0][second]], axis=1),
        segment_weights=np.concatenate([-joined[1][first], joined[1][second]], axis=1),
    )


@kernel
def combined(x: Array, nodes: Ints, weights: Array, fixed: Array) -> Array:
    """Positions (p, 3) of combinations of nodes [m].

    Args:
        x: (n_nodes, 3) node positions [m].
        nodes: (p, k) nodes of the points.
        weights: (p, k) their weights.
        fixed: (p, 3) what is added to them [m].
    """
    y = fixed.copy()
    for p in range(nodes.shape[0]):
        for a in range(nodes.shape[1]):
            for i in range(3):
                y[p, i] += weights[p, a] * x[nodes[p, a], i]
    return y


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
