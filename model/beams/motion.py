"""Motion of a tree of beams: positions, rotations and their derivatives from natural strains.

With R the frame of the first end a of an element, r and T of `tauten.model.beams.helix`, and
velocity v_a and angular velocity w_a of that end, those of the other end b are

    w_b = w_a + R T dφ
    v_b = v_a + w_a x R r + R (T de + ∂r/∂φ dφ),   de of dε by (B2)                (B4)

so one pass from the fixed nodes outwards gives all of them. With J the velocities and angular velocities of
all nodes per rate of the strains, forces and moments g on the nodes are Jᵀ g for the strains, which one pass
back to the fixed nodes gives.
"""

from __future__ import annotations

import numpy as np

from tauten.model.beams.elements import (
    BeamArrays,
    Pair,
    offset_slopes,
    stretch_functions,
    stretched,
)
from tauten.model.beams.helix import along_helix, chord_change
from tauten.model.beams.tree import element_frame
from tauten.model.numerics import (
    Array,
    Vector3,
    conjugate,
    cross,
    dot,
    from_rotation_vector,
    kernel,
    normalised,
    product,
    quaternion,
    rotate,
    row,
    scale,
    subtract,
)


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
        frame, phi, e, chord = place_end(strains, beams, k, x, Q)
        for i in range(3):
            unit = unit_vector(i)
            along[i] = rotate(frame, along_helix(phi, unit))
            moved[i] = rotate(frame, chord_change(phi, e, unit))
        slopes = offset_slopes(beams, k, e)
        follow_end(chord, along, moved, slopes, 6 * a, 6 * b, Phi[s : s + 6], J)


@kernel
def strained_length(strains: Array, beams: BeamArrays, k: int) -> Vector3:
    """Length e of an element with stretch and shear [m].

    Args:
        strains: (6 e,) natural strains [m], [rad].
        beams: the elements.
        k: number of this one.
    """
    s, offsets = 6 * k, (0.0, strains[6 * k + 1], strains[6 * k + 2])
    slopes = offset_slopes(beams, k, offsets)
    longer = 0.5 * (slopes[0] * offsets[1] + slopes[1] * offsets[2])
    return strains[s] + beams.length[k] - longer, offsets[1], offsets[2]


@kernel
def place_end(
    strains: Array, beams: BeamArrays, k: int, x: Array, Q: Array
) -> tuple[tuple[float, float, float, float], Vector3, Vector3, Vector3]:
    """Place the outer end of an element; returns its frame at the other end, φ, e and its chord [m].

    Args:
        strains: (6 e,) natural strains [m], [rad].
        beams: the elements.
        k: number of this one.
        x: (n_nodes, 3) positions [m]; the row of the outer end is output.
        Q: (n_nodes, 4) rotations, unit quaternions; the row of the outer end is output.
    """
    a, b, s = beams.ends[k, 0], beams.ends[k, 1], 6 * k
    e = strained_length(strains, beams, k)
    phi = (strains[s + 3], strains[s + 4], strains[s + 5])
    axes = quaternion(beams.axes, k)
    frame = product(quaternion(Q, a), axes)
    end = normalised(product(product(frame, from_rotation_vector(phi)), conjugate(axes)))
    chord = rotate(frame, along_helix(phi, e))
    for i in range(3):
        x[b, i] = x[a, i] + chord[i]
    for i in range(4):
        Q[b, i] = end[i]
    return frame, phi, e, chord


@kernel
def strain_forces(x: Array, Q: Array, load: Array, beams: BeamArrays) -> Array:
    """Jᵀ g: what forces and moments on the nodes are for the natural strains, (6 e,) [N], [N m].

    Args:
        x: (n_nodes, 3) positions [m].
        Q: (n_nodes, 4) rotations, unit quaternions.
        load: (n_nodes, 6) forces and moments g [N], [N m]; summed up towards the fixed nodes.
        beams: the elements, each after the one that leads to it.
    """
    found = np.empty(6 * beams.ends.shape[0])
    for k in range(beams.ends.shape[0] - 1, -1, -1):
        a, b = beams.ends[k]
        _, phi, u = element_frame(x, Q, beams, k)
        gamma, eta, _, _, _, _ = stretch_functions(dot(phi, phi) ** 0.5)
        e, back = (
            stretched(u, phi, gamma, eta),
            conjugate(product(quaternion(Q, a), quaternion(beams.axes, k))),
        )
        force, moment = row(load[:, :3], b), row(load[:, 3:], b)
        F, M = rotate(back, force), rotate(back, moment)
        away = scale(-1.0, phi)
        bend = along_helix(away, M)
        stretch = along_helix(away, F)
        for i in range(3):
            found[6 * k + i] = stretch[i]
            found[6 * k + 3 + i] = bend[i] + dot(chord_change(phi, e, unit_vector(i)), F)
        slopes = offset_slopes(beams, k, e)
        found[6 * k + 1] -= slopes[0] * stretch[0]
        found[6 * k + 2] -= slopes[1] * stretch[0]
        lever = cross(subtract(row(x, b), row(x, a)), force)
        for i in range(3):
            load[a, i] += force[i]
            load[a, 3 + i] += moment[i] + lever[i]
    return found


@kernel
def follow_end(
    r: Vector3, along: Array, moved: Array, slopes: Pair, a: int, b: int, Phi: Array, J: Array
) -> None:
    """Rows b … b + 5 of J, the motion of one end of an element, from those of the other end (B4).

    Args:
        r: chord from the first to this end [m].
        along: (3, 3) columns of R T, one in each row.
        moved: (3, 3) columns of R ∂r/∂φ, one in each row.
        slopes: see `offset_slopes`.
        a: first row of the other end.
        b: first row of this end.
        Phi: (6, r) modes of the strains of the element.
        J: (6 n_nodes, r) updated.
    """
    (r0, r1, r2), t, m = r, along, moved
    for j in range(J.shape[1]):
        w0, w1, w2 = J[a + 3, j], J[a + 4, j], J[a + 5, j]
        e1, e2 = Phi[1, j], Phi[2, j]
        e0 = Phi[0, j] - slopes[0] * e1 - slopes[1] * e2
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
