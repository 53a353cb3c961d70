"""Curvature of cables and forces on points that are attached to beams; signs as in `paths`.

A hole lies at a distance from the node it is attached to. When the node turns, the force at the hole keeps
its direction while its lever arm turns: with force f and arm r this adds (f·r) I − ½ (r fᵀ + f rᵀ) to the
tangent of the node's rotation.
"""

from __future__ import annotations

import numpy as np

from tauten.model.numerics import Array, Ints, Vector3, dot, kernel, row, scale
from tauten.model.points.paths import Segments, blunted


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
    points: Array, arms: Array, segments: Segments, effort: Array, exact: bool,
    blocks: tuple[Ints, Ints], K: Array,
) -> None:  # fmt: skip
    """Add the curvature of tensioned cables to the CSC values K (nnz,).

    Args:
        points: (p, 3) stations [m].
        arms: (p, 2, 3) their lever arms [m].
        segments: see `Paths.segment_arrays`; the second station is the next.
        effort: (n_a,) [N].
        exact: with the rotation of lever arms, which may make the tangent indefinite.
        blocks: slot (s, 4, 4) and column_length (s, 4), see `Pattern.blocks`; groups are position and
            rotation of both nodes.
        K: (nnz,) values of −∂force.
    """
    first, owner, shortest = segments
    slot, column_length = blocks
    G, part = np.zeros((3, 12)), np.zeros((12, 12))
    for s in range(first.shape[0]):
        p = first[s]
        d = points[p + 1] - points[p]
        ell = np.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
        T = effort[owner[s]]
        if T == 0.0 or (T < 0.0 and not exact):
            continue
        _, slope, curvature = blunted(ell, shortest[s])
        bend = (curvature - slope) / (ell * ell) if ell > 0.0 else 0.0
        for end in range(2):  # d changes by G times the motion of both nodes
            sign, r = 2.0 * end - 1.0, row(arms[p + end], 0)
            for i in range(3):
                G[i, 6 * end + i] = sign
            G[0, 6 * end + 4], G[0, 6 * end + 5] = sign * r[2], -sign * r[1]
            G[1, 6 * end + 5], G[1, 6 * end + 3] = sign * r[0], -sign * r[2]
            G[2, 6 * end + 3], G[2, 6 * end + 4] = sign * r[1], -sign * r[0]
        for j in range(12):
            along = bend * (d[0] * G[0, j] + d[1] * G[1, j] + d[2] * G[2, j])
            for i in range(12):
                value = 0.0
                for k in range(3):
                    value += G[k, i] * (slope * G[k, j] + d[k] * along)
                part[i, j] = T * value
        if exact:
            for end in range(2):
                f, r = (
                    scale(T * (1.0 - 2.0 * end) * slope, (d[0], d[1], d[2])),
                    row(arms[p + end], 0),
                )
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


@kernel
def add_lever_stiffness(forces: Array, arms: Array, blocks: tuple[Ints, Ints], K: Array) -> None:
    """Add what the turning of lever arms under forces of fixed direction adds to the CSC values K (nnz,).

    Args:
        forces: (p, 3) on points that are attached to one node each [N].
        arms: (p, 2, 3) their lever arms [m].
        blocks: slot (p, 1, 1) and column_length (p, 1), see `Pattern.blocks`; groups are the rotations of
            the nodes.
        K: (nnz,) values of −∂force.
    """
    slot, column_length = blocks
    for p in range(forces.shape[0]):
        if slot[p, 0, 0] < 0:
            continue
        f, r = row(forces, p), row(arms[p], 0)
        for j in range(3):
            for i in range(3):
                K[slot[p, 0, 0] + j * column_length[p, 0] + i] += lever_block(f, r, i, j)
