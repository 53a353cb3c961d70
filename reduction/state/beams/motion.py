"""Motion of a tree of beams: positions, rotations and their derivatives from natural strains.

With R the frame of the first end a of an element, r and T of `tauten.reduction.state.beams.helix`, and
velocity v_a and angular velocity w_a of that end, those of the other end b are

    w_b = w_a + R T dφ
    v_b = v_a + w_a x R r + R (T dε + ∂r/∂φ dφ)                                   (B4)

so one pass from the fixed nodes outwards gives all of them.
"""

from __future__ import annotations

import numpy as np

from tauten.model.beams import BeamArrays
from tauten.model.numerics import (
    Array,
    Ints,
    Vector3,
    conjugate,
    cross,
    from_rotation_vector,
    kernel,
    normalised,
    product,
    quaternion,
    rotate,
    row,
)
from tauten.reduction.state.beams.helix import along_helix, chord_change


@kernel
def unit_vector(i: int) -> Vector3:
    """Along axis i."""
    return (1.0 if i == 0 else 0.0, 1.0 if i == 1 else 0.0, 1.0 if i == 2 else 0.0)


@kernel
def follow(strains: Array, Phi: Array, beams: BeamArrays, x: Array, Q: Array, J: Array) -> None:
    """Positions and rotations of all nodes, and their derivatives along the modes.

    Args:
        strains: (6 e,) natural strains [m], [rad].
        Phi: (6 e, r) their modes.
        beams: the elements, each after the one that leads to it.
        x: (n_nodes, 3) output [m]; rows of fixed nodes are given.
        Q: (n_nodes, 4) output, unit quaternions; rows of fixed nodes are given.
        J: (6 n_nodes, r) output: velocity and angular velocity of each node per rate of each mode; rows of
            fixed nodes are given as zero.
    """
    along, moved = np.empty((3, 3)), np.empty((3, 3))  # R T and R ∂r/∂φ, by columns
    for k in range(beams.ends.shape[0]):
        a, b, s = beams.ends[k, 0], beams.ends[k, 1], 6 * k
        e = (strains[s] + beams.length[k], strains[s + 1], strains[s + 2])
        phi = (strains[s + 3], strains[s + 4], strains[s + 5])
        axes = quaternion(beams.axes, k)
        frame = product(quaternion(Q, a), axes)
        end = normalised(product(product(frame, from_rotation_vector(phi)), conjugate(axes)))
        chord = rotate(frame, along_helix(phi, e))
        for i in range(3):
            x[b, i] = x[a, i] + chord[i]
        for i in range(4):
            Q[b, i] = end[i]
        for i in range(3):
            unit = unit_vector(i)
            along[i] = rotate(frame, along_helix(phi, unit))
            moved[i] = rotate(frame, chord_change(phi, e, unit))
        follow_end(chord, along, moved, 6 * a, 6 * b, Phi[s : s + 6], J)


@kernel
def follow_end(
    r: Vector3, along: Array, moved: Array, a: int, b: int, Phi: Array, J: Array
) -> None:
    """Rows b … b + 5 of J, the motion of one end of an element, from those of the other end (B4).

    Args:
        r: chord from the first to this end [m].
        along: (3, 3) columns of R T, one in each row.
        moved: (3, 3) columns of R ∂r/∂φ, one in each row.
        a: first row of the other end.
        b: first row of this end.
        Phi: (6, r) modes of the strains of the element.
        J: (6 n_nodes, r) updated.
    """
    (r0, r1, r2), t, m = r, along, moved
    for j in range(J.shape[1]):
        w0, w1, w2 = J[a + 3, j], J[a + 4, j], J[a + 5, j]
        e0, e1, e2 = Phi[0, j], Phi[1, j], Phi[2, j]
        p0, p1, p2 = Phi[3, j], Phi[4, j], Phi[5, j]
        J[b, j] = (
            J[a, j] + (w1 * r2 - w2 * r1) + (t[0, 0] * e0 + t[1, 0] * e1 + t[2, 0] * e2)
            + (m[0, 0] * p0 + m[1, 0] * p1 + m[2, 0] * p2)
        )  # fmt: skip
        J[b + 1, j] = (
            J[a + 1, j] + (w2 * r0 - w0 * r2) + (t[0, 1] * e0 + t[1, 1] * e1 + t[2, 1] * e2)
            + (m[0, 1] * p0 + m[1, 1] * p1 + m[2, 1] * p2)
        )  # fmt: skip
        J[b + 2, j] = (
            J[a + 2, j] + (w0 * r1 - w1 * r0) + (t[0, 2] * e0 + t[1, 2] * e1 + t[2, 2] * e2)
            + (m[0, 2] * p0 + m[1, 2] * p1 + m[2, 2] * p2)
        )  # fmt: skip
        J[b + 3, j] = w0 + t[0, 0] * p0 + t[1, 0] * p1 + t[2, 0] * p2
        J[b + 4, j] = w1 + t[0, 1] * p0 + t[1, 1] * p1 + t[2, 1] * p2
        J[b + 5, j] = w2 + t[0, 2] * p0 + t[1, 2] * p1 + t[2, 2] * p2


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
