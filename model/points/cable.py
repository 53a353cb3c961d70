"""Cables that slide through points of the body: pulled length, its gradient, its curvature.

δ_a = L(q₀) − L(q) is the length pulled in, H_a = −∂L/∂q, the force on the body is H_aᵀ λ_a.
Since H_a turns with the body, a tension adds λ_a ∂²L/∂q² to the tangent: positive semidefinite, as L is
convex, and negative semidefinite in a rod that pushes.

An equilibrium in which the ends of a segment have met is common: a trunk curls until its discs meet. There
|d| has a kink, which Newton's method does not pass, so that lengths are rounded below `SHORTEST`.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy.sparse as sp

from tauten.model.numerics import Array, Ints, kernel
from tauten.model.points.material_points import MaterialPoints
from tauten.model.rows import Rows

SHORTEST = 5e-4  # m, distance of a segment's ends below which its length is rounded


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
    """All cables of a robot as arrays for the kernels.

    Each segment joins two stations; a station is four nodes and weights plus a fixed offset (the
    pull point has zero weights).

    Attributes:
        owner: (s,) cable of each segment.
        nodes: (s, 8) nodes of both stations.
        weights: (s, 8) their weights, the first station's negated: difference = Σ w x + offset.
        offset: (s, 3) fixed part of the difference [m].
        rest_length: (n_a,) L(q₀) [m].
    """

    owner: Ints
    nodes: Ints
    weights: Array
    offset: Array
    rest_length: Array

    @property
    def n_a(self) -> int:
        """Number of cables."""
        return len(self.rest_length)

    def segments(self, x: Array) -> Array:
        """Both ends of every segment at node positions x (n_nodes, 3): (s, 2, 3) [m], for drawing."""
        parts = self.weights[:, :, None] * x[self.nodes]  # (s, 8, 3)
        second = parts[:, 4:].sum(axis=1)  # only a first end may be fixed outside the body
        first = second - self.offset - parts.sum(axis=1)
        return np.stack([first, second], axis=1)

    def rows(self, x: Array, dof: Ints, n: int) -> Rows:
        """Pulled lengths and H_a = −∂L/∂q: Rows of (n_a, n) [m].

        Args:
            x: (n_nodes, 3) node positions [m].
            dof: (n_nodes,) first degree of freedom of a node, −1 where it is fixed.
            n: number of degrees of freedom.
        """
        length, gradient = cable_gradients(
            x, self.owner, self.nodes, self.weights, self.offset, self.n_a
        )
        columns = dof[self.nodes][:, :, None] + np.arange(3)  # (s, 8, 3)
        free = columns[:, :, 0] >= 0
        row = np.broadcast_to(self.owner[:, None, None], columns.shape)
        H = sp.csr_array(
            (-gradient[free].ravel(), (row[free].ravel(), columns[free].ravel())),
            shape=(self.n_a, n),
        )
        return Rows(H, self.rest_length - length)


def make_cables(cables: list[Cable], x0: Array) -> CableSet:
    """Arrays of the cables, rest lengths measured at node positions x0 (n_nodes, 3)."""
    owner, nodes, weights, offset = [], [], [], []
    for index, cable in enumerate(cables):
        points = zip(cable.points.nodes, cable.points.weights, strict=True)
        stations = [(n, w, np.zeros(3)) for n, w in points]
        if cable.pull_point is not None:
            first = cable.points.nodes[0]
            stations.insert(0, (first, np.zeros(4), np.asarray(cable.pull_point, dtype=float)))
        for (n0, w0, o0), (n1, w1, o1) in pairwise(stations):
            owner.append(index)
            nodes.append(np.concatenate([n0, n1]))
            weights.append(np.concatenate([-w0, w1]))
            offset.append(o1 - o0)
    arrays = (
        np.array(owner, dtype=np.int64),
        np.array(nodes, dtype=np.int64).reshape(-1, 8),
        np.array(weights).reshape(-1, 8),
        np.array(offset).reshape(-1, 3),
    )
    rest_length, _ = cable_gradients(x0, *arrays, len(cables))
    return CableSet(*arrays, rest_length)


@kernel
def blunted(length: float) -> tuple[float, float, float]:
    """Length f of a segment as the cable has it [m], f'(length) / length and f''(length) [1/m].

    |d| itself from `SHORTEST` on; below, the even polynomial of fourth degree that continues it with two
    derivatives.

    Args:
        length: distance of the segment's ends [m].
    """
    if length >= SHORTEST:
        return length, 1.0 / length, 0.0
    t = length / SHORTEST
    value = SHORTEST * (0.375 + 0.75 * t * t - 0.125 * t**4)
    return value, (1.5 - 0.5 * t * t) / SHORTEST, 1.5 * (1.0 - t * t) / SHORTEST


@kernel
def cable_gradients(
    x: Array, owner: Ints, nodes: Ints, weights: Array, offset: Array, n_a: int
) -> tuple[Array, Array]:
    """Lengths (n_a,) [m] and the gradient of each segment's length (s, 8, 3).

    Args:
        x: (n_nodes, 3) node positions [m].
        owner: (s,) cable of every segment.
        nodes: (s, 8) nodes of its two ends.
        weights: (s, 8) of the nodes, negative for the first end.
        offset: (s, 3) constant part of the vector from the first end to the second [m].
        n_a: number of cables.
    """
    length = np.zeros(n_a)
    gradient = np.zeros((owner.shape[0], 8, 3))
    d = np.empty(3)
    for s in range(owner.shape[0]):
        d[:] = offset[s]
        for a in range(8):
            for i in range(3):
                d[i] += weights[s, a] * x[nodes[s, a], i]
        ell = np.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
        value, slope, _ = blunted(ell)
        length[owner[s]] += value
        for a in range(8):
            for i in range(3):
                gradient[s, a, i] = weights[s, a] * d[i] * slope
    return length, gradient


@kernel
def add_cable_stiffness(  # noqa: C901  one flat loop nest is what numba compiles best
    x: Array,
    owner: Ints,
    nodes: Ints,
    weights: Array,
    offset: Array,
    tension: Array,
    blocks: tuple[Ints, Ints],
    K: Array,
) -> None:
    """Add λ_a ∂²L/∂q² of every segment to a tangent.

    Args:
        x: (n_nodes, 3) node positions [m].
        owner: (s,) cable of every segment.
        nodes: (s, 8) nodes of its two ends.
        weights: (s, 8) of the nodes, negative for the first end.
        offset: (s, 3) constant part of the vector from the first end to the second [m].
        tension: (n_a,) [N].
        blocks: slot (s, 8, 8) and column_length (s, 8), see `Pattern.blocks`.
        K: (nnz,) CSC values of −∂force, added to.
    """
    slot, column_length = blocks
    d = np.empty(3)
    for s in range(owner.shape[0]):
        force = tension[owner[s]]
        d[:] = offset[s]
        for a in range(8):
            for i in range(3):
                d[i] += weights[s, a] * x[nodes[s, a], i]
        ell = np.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
        if force == 0.0:
            continue
        _, slope, curvature = blunted(ell)
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
