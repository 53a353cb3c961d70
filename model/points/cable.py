"""Cables that slide through points of the body: pulled length, its gradient, its curvature.

δ_a = L(q₀) − L(q) is the length pulled in, H_a = −∂L/∂q, the force on the body is H_aᵀ λ_a.
Since H_a turns with the body, a tension adds λ_a ∂²L/∂q² to the tangent: positive semidefinite, as L is
convex, and negative semidefinite in a rod that pushes.

An equilibrium in which the ends of a segment have met is common: a trunk curls until its discs meet. There
|d| has a kink, which Newton's method does not pass, so that lengths are rounded below `SHORTEST`, or below
half of the segment's length at rest where that is less: segments of small robots are straight too.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

import numpy as np
import scipy.sparse as sp

from tauten.model.numerics import Array, Ints, kernel
from tauten.model.points.material_points import MaterialPoints
from tauten.model.rows import Rows

SHORTEST = 5e-4  # m, largest distance of a segment's ends below which its length is rounded
_LEAST = 1e-5  # m, the least one, of segments whose ends meet at rest
Segments: TypeAlias = tuple[Ints, Ints, Array, Array, Array]


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
        shortest: (s,) distance of the ends below which the length is rounded [m].
        rest_length: (n_a,) L(q₀) [m].
    """

    owner: Ints
    nodes: Ints
    weights: Array
    offset: Array
    shortest: Array
    rest_length: Array

    @property
    def n_a(self) -> int:
        """Number of cables."""
        return len(self.rest_length)

    @property
    def segment_arrays(self) -> Segments:
        """Owner, nodes, weights, offset and shortest of all segments, for the kernels."""
        return self.owner, self.nodes, self.weights, self.offset, self.shortest

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
        length, gradient = cable_gradients(x, self.segment_arrays, self.n_a)
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
    alone = (np.arange(len(owner)), *arrays[1:], np.zeros(len(owner)))  # each segment a cable
    own_length, _ = cable_gradients(x0, alone, len(owner))
    shortest = np.clip(0.5 * own_length, _LEAST, SHORTEST)
    rest_length, _ = cable_gradients(x0, (*arrays, shortest), len(cables))
    return CableSet(*arrays, shortest, rest_length)


@kernel
def blunted(length: float, shortest: float) -> tuple[float, float, float]:
    """Length f of a segment as the cable has it [m], f'(length) / length and f''(length) [1/m].

    |d| itself from the shortest on; below, the even polynomial of fourth degree that continues it with two
    derivatives.

    Args:
        length: distance of the segment's ends [m].
        shortest: below which it is rounded [m].
    """
    if length > 0.0 and length >= shortest:
        return length, 1.0 / length, 0.0
    if shortest == 0.0:
        return 0.0, 0.0, 0.0
    t = length / shortest
    value = shortest * (0.375 + 0.75 * t * t - 0.125 * t**4)
    return value, (1.5 - 0.5 * t * t) / shortest, 1.5 * (1.0 - t * t) / shortest


@kernel
def cable_gradients(x: Array, segments: Segments, n_a: int) -> tuple[Array, Array]:
    """Lengths (n_a,) [m] and the gradient of each segment's length (s, 8, 3).

    Args:
        x: (n_nodes, 3) node positions [m].
        segments: see `CableSet.segment_arrays`.
        n_a: number of cables.
    """
    owner, nodes, weights, offset, shortest = segments
    length = np.zeros(n_a)
    gradient = np.zeros((owner.shape[0], 8, 3))
    d = np.empty(3)
    for s in range(owner.shape[0]):
        d[:] = offset[s]
        for a in range(8):
            for i in range(3):
                d[i] += weights[s, a] * x[nodes[s, a], i]
        ell = np.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
        value, slope, _ = blunted(ell, shortest[s])
        length[owner[s]] += value
        for a in range(8):
            for i in range(3):
                gradient[s, a, i] = weights[s, a] * d[i] * slope
    return length, gradient


@kernel
def add_cable_stiffness(  # noqa: C901  one flat loop nest is what numba compiles best
    x: Array, segments: Segments, tension: Array, blocks: tuple[Ints, Ints], K: Array
) -> None:
    """Add λ_a ∂²L/∂q² of every segment to a tangent.

    Args:
        x: (n_nodes, 3) node positions [m].
        segments: see `CableSet.segment_arrays`.
        tension: (n_a,) [N].
        blocks: slot (s, 8, 8) and column_length (s, 8), see `Pattern.blocks`.
        K: (nnz,) CSC values of −∂force, added to.
    """
    owner, nodes, weights, offset, shortest = segments
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
