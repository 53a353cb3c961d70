"""Cables that slide through points attached to beams; signs and curvature as in `tauten.model.points.cable`.

A hole lies at a distance from the node it is attached to. When the node turns, the force at the hole keeps
its direction while its lever arm turns: with force f and arm r this adds (f·r) I − ½ (r fᵀ + f rᵀ) to the
tangent of the node's rotation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.numerics import Array, Ints, Vector3, dot, kernel, row, scale
from tauten.model.points.attached_points import AttachedPoints, Entries, join_attached_points
from tauten.model.rows import Rows


@dataclass(frozen=True, slots=True)
class BeamCables:
    """All cables of a robot made of beams.

    Attributes:
        stations: points that cables pass, each fixed to one node, cable by cable.
        starts: (n_a + 1,) where each cable's stations start.
        first: (s,) first station of every segment, cable by cable; the second one is the next.
        owner: (s,) cable of every segment.
        rest_length: (n_a,) L(q₀) [m].
    """

    stations: AttachedPoints
    starts: Ints
    first: Ints
    owner: Ints
    rest_length: Array

    @property
    def n_a(self) -> int:
        """Number of cables."""
        return len(self.rest_length)

    @property
    def ends(self) -> Ints:
        """Nodes at both ends of every segment, cable by cable: (s, 2)."""
        node = self.stations.nodes[:, 0]
        return np.stack([node[self.first], node[self.first + 1]], axis=1)

    def segments(self, x: Array, Q: Array) -> Array:
        """Both ends of every segment: (s, 2, 3) [m], for drawing.

        Args:
            x: (n_nodes, 3) node positions [m].
            Q: (n_nodes, 4) node rotations.
        """
        points, _ = self.stations.place(x, Q)
        return np.stack([points[self.first], points[self.first + 1]], axis=1)

    def rows(self, x: Array, Q: Array, dof: Ints, n: int) -> Rows:
        """Pulled lengths and H_a = −∂L/∂q: Rows of (n_a, n) [m].

        Args:
            x: (n_nodes, 3) node positions [m].
            Q: (n_nodes, 4) node rotations.
            dof: (n_nodes,) first degree of freedom of a node, −1 where it is fixed.
            n: number of degrees of freedom.
        """
        points, arms = self.stations.place(x, Q)
        delta, entries = self.pulled(points)
        return Rows(self.stations.rows(arms, dof, n, entries), delta)

    def pulled(self, points: Array) -> tuple[Array, Entries]:
        """Pulled lengths (n_a,) [m] at stations (p, 3), and −∂L as rows over the stations."""
        length, vectors = lengths(points, self.starts)
        return self.rest_length - length, Entries(self.starts, np.arange(len(points)), vectors)


def make_beam_cables(cables: list[AttachedPoints], x: Array, Q: Array) -> BeamCables:
    """Cables through points.

    Args:
        cables: the points of each cable, in the order it passes them.
        x: (n_nodes, 3) node positions at which rest lengths are measured [m].
        Q: (n_nodes, 4) node rotations there.
    """
    stations = join_attached_points(cables)
    counts = [len(cable) for cable in cables]
    starts = np.cumsum([0, *counts]).astype(np.int64)
    owner = np.repeat(np.arange(len(cables)), np.array(counts) - 1)
    first = np.setdiff1d(np.arange(len(stations)), starts[1:] - 1)
    rest_length, _ = lengths(stations.place(x, Q)[0], starts)
    return BeamCables(stations, starts, first, owner, rest_length)


@kernel
def lengths(points: Array, starts: Ints) -> tuple[Array, Array]:
    """Lengths (n_a,) of the cables and −∂length by their stations (p, 3)."""
    length, vectors = np.zeros(starts.shape[0] - 1), np.zeros(points.shape)
    for cable in range(starts.shape[0] - 1):
        for p in range(starts[cable], starts[cable + 1] - 1):
            d = points[p + 1] - points[p]
            ell = np.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
            length[cable] += ell
            if ell > 0.0:
                vectors[p] += d / ell
                vectors[p + 1] -= d / ell
    return length, vectors


@kernel
def lever_block(f: Vector3, r: Vector3, i: int, j: int) -> float:
    """Entry (i, j) of the tangent of a lever arm r [m] that turns under a force f [N].

    Args:
        f: force [N].
        r: lever arm [m].
        i: row, 0 to 2.
        j: column, 0 to 2.
    """
    value = -0.5 * (r[i] * f[j] + f[i] * r[j])
    return value + dot(f, r) if i == j else value


@kernel
def add_beam_cable_stiffness(  # noqa: C901  one flat loop nest is what numba compiles best
    points: Array, arms: Array, first: Ints, owner: Ints, tension: Array, exact: bool,
    blocks: tuple[Ints, Ints], K: Array,
) -> None:  # fmt: skip
    """Add the curvature of tensioned cables to the CSC values K (nnz,).

    Args:
        points: (p, 3) stations [m].
        arms: (p, 2, 3) their lever arms [m].
        first: (s,) first station of each segment, the second is the next.
        owner: (s,) cable of each segment.
        tension: (n_a,) [N].
        exact: with the rotation of lever arms, which may make the tangent indefinite.
        blocks: slot (s, 4, 4) and column_length (s, 4), see `Pattern.blocks`; groups are position and
            rotation of both nodes.
        K: (nnz,) values of −∂force.
    """
    slot, column_length = blocks
    G, part = np.zeros((3, 12)), np.zeros((12, 12))
    for s in range(first.shape[0]):
        p = first[s]
        d = points[p + 1] - points[p]
        ell = np.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
        T = tension[owner[s]]
        if T == 0.0 or (T < 0.0 and not exact) or ell <= 0.0:
            continue
        e = (d[0] / ell, d[1] / ell, d[2] / ell)
        for end in range(2):  # d changes by G times the motion of both nodes
            sign, r = 2.0 * end - 1.0, row(arms[p + end], 0)
            for i in range(3):
                G[i, 6 * end + i] = sign
            G[0, 6 * end + 4], G[0, 6 * end + 5] = sign * r[2], -sign * r[1]
            G[1, 6 * end + 5], G[1, 6 * end + 3] = sign * r[0], -sign * r[2]
            G[2, 6 * end + 3], G[2, 6 * end + 4] = sign * r[1], -sign * r[0]
        for j in range(12):
            along = e[0] * G[0, j] + e[1] * G[1, j] + e[2] * G[2, j]
            for i in range(12):
                value = 0.0
                for k in range(3):
                    value += G[k, i] * (G[k, j] - e[k] * along)
                part[i, j] = T / ell * value
        if exact:
            for end in range(2):
                f, r = scale(T * (1.0 - 2.0 * end), e), row(arms[p + end], 0)
                for i in range(3):
                    for j in range(3):
                        part[6 * end + 3 + i, 6 * end + 3 + j] += lever_block(f, r, i, j)
        for a in range(4):
            for b in range(4):
                if slot[s, a, b] >= 0:
                    for j in range(3):
                        for i in range(3):
                            place = slot[s, a, b] + j * column_length[s, b] + i
                            K[place] += part[3 * a + i, 3 * b + j]
