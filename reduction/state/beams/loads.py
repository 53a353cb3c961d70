"""How the turning of a tree of beams changes the power of loads: second derivatives of loaded points.

Loads are forces on points that move with the nodes. The points beyond an element have, in the frame of its
first end, the positions y = r + ρ with the chord r = exp(φ/2) u and ρ turned by exp(φ). Strain rates dε
move them by V + Ω x ρ, and with θ(a) = J_l(a) da, the spin of exp(a),

    V = exp(φ/2) du + θ(φ/2) x r,   Ω = θ(φ)
    ∂²(Σ F·y) = ω·(V x F + A Ω)                                  one turn ω before the element
              + F·(2 θ(φ/2) x exp(φ/2) du)                       and within the element
              + θ(φ/2)ᵀ (r Fᵀ − r·F I) θ(φ/2) + (r x F)·dθ(φ/2)
              + θ(φ)ᵀ A θ(φ) + (Σ ρ x F)·dθ(φ),   A = S − tr(S) I,   S = Σ ρ Fᵀ         (B5)

so that F and S, summed over what lies beyond, are all that is needed of it. (Park, Kim and Ploen compute such
derivatives for serial chains: ASME Journal of Mechanical Design 121, 1999.)
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
    dot,
    from_rotation_vector,
    kernel,
    product,
    quaternion,
    rotate,
    row,
    scale,
    subtract,
)
from tauten.reduction.state.beams.motion import unit_vector


@kernel
def loads_beyond(force: Array, moment: Array, x: Array, ends: Ints, F: Array, S: Array) -> None:
    """Sums of the loads on what lies beyond each node, the node itself included.

    Args:
        force: (n_nodes, 3) loads on each node and the points fixed to it [N].
        moment: (n_nodes, 3, 3) their Σ ρ Fᵀ, ρ from the node [N m].
        x: (n_nodes, 3) positions [m].
        ends: (e, 2) nodes of the elements, outwards.
        F: (n_nodes, 3) output [N].
        S: (n_nodes, 3, 3) output, Σ ρ Fᵀ with ρ from the node [N m].
    """
    F[:], S[:] = force, moment
    for k in range(ends.shape[0] - 1, -1, -1):
        a, b = ends[k]
        for i in range(3):
            F[a, i] += F[b, i]
            for j in range(3):
                S[a, i, j] += S[b, i, j] + (x[b, i] - x[a, i]) * F[b, j]


@kernel
def add_point_loads(
    vectors: Array, nodes: Ints, weights: Array, arms: Array, force: Array, moment: Array
) -> None:
    """Add forces on attached points to the loads of their nodes.

    Args:
        vectors: (p, 3) forces [N].
        nodes: (p, 2) nodes of the points.
        weights: (p, 2) their weights.
        arms: (p, 2, 3) weighted lever arms [m].
        force: (n_nodes, 3) accumulated [N].
        moment: (n_nodes, 3, 3) accumulated Σ ρ Fᵀ [N m].
    """
    for p in range(nodes.shape[0]):
        for side in range(2):
            if weights[p, side] == 0.0:
                continue
            n = nodes[p, side]
            for i in range(3):
                force[n, i] += weights[p, side] * vectors[p, i]
                for j in range(3):
                    moment[n, i, j] += arms[p, side, i] * vectors[p, j]


@kernel
def spin_functions(t: float) -> tuple[float, float, float, float, float, float]:
    """A, B, C of J_l(a) da = A da + B a x da + C (a·da) a and their derivatives by t = |a|, divided by t."""
    t2 = t * t
    if t < 0.3:  # Taylor series, exact to rounding here
        A = 1.0 - t2 / 6.0 * (1.0 - t2 / 20.0 * (1.0 - t2 / 42.0 * (1.0 - t2 / 72.0)))
        B = 0.5 - t2 / 24.0 * (1.0 - t2 / 30.0 * (1.0 - t2 / 56.0 * (1.0 - t2 / 90.0)))
        C = 1.0 / 6.0 - t2 / 120.0 * (1.0 - t2 / 42.0 * (1.0 - t2 / 72.0 * (1.0 - t2 / 110.0)))
        dA = -1.0 / 3.0 + t2 * (1.0 / 30.0 - t2 * (1.0 / 840.0 - t2 * (1.0 / 45360.0)))
        dB = -1.0 / 12.0 + t2 * (1.0 / 180.0 - t2 * (1.0 / 6720.0 - t2 * (1.0 / 453600.0)))
        dC = -1.0 / 60.0 + t2 * (1.0 / 1260.0 - t2 * (1.0 / 60480.0 - t2 * (1.0 / 4989600.0)))
        return A, B, C, dA, dB, dC
    sine, cosine = np.sin(t), np.cos(t)
    A, B, C = sine / t, (1.0 - cosine) / t2, (t - sine) / (t2 * t)
    return A, B, C, (cosine - A) / t2, (A - 2.0 * B) / t2, (B - 3.0 * C) / t2


@kernel
def spin(a: Vector3, da: Vector3) -> Vector3:
    """J_l(a) da, the spin of exp(a) in a change da of its rotation vector."""
    A, B, C, _, _, _ = spin_functions(dot(a, a) ** 0.5)
    across, along = cross(a, da), C * dot(a, da)
    return (
        A * da[0] + B * across[0] + along * a[0],
        A * da[1] + B * across[1] + along * a[1],
        A * da[2] + B * across[2] + along * a[2],
    )


@kernel
def add_spin_change(m: Vector3, a: Vector3, factor: float, C: Array) -> None:
    """Add factor m·dθ(a), a quadratic form of da, to the block of φ of the symmetric C (6, 6).

    Args:
        m: moment [N m].
        a: rotation vector.
        factor: of the form.
        C: (6, 6) accumulated.
    """
    _, _, c, dA, dB, dC = spin_functions(dot(a, a) ** 0.5)
    along, across = dot(a, m), cross(m, a)
    for i in range(3):
        for j in range(3):
            b_i = (dA + c) * m[i] + dB * across[i] + dC * along * a[i]
            b_j = (dA + c) * m[j] + dB * across[j] + dC * along * a[j]
            value = 0.5 * (a[i] * b_j + b_i * a[j])
            if i == j:
                value += c * along
            C[3 + i, 3 + j] += factor * value


@kernel
def load_terms(
    frame: tuple[float, float, float, float],
    u: Vector3,
    phi: Vector3,
    F: Array,
    S: Array,
    B: Array,
    C: Array,
) -> None:
    """The terms of (B5) of one element: ω·B dε with a turn ω in space, and dεᵀ C dε.

    Args:
        frame: rotation of its first end with its axes.
        u: its chord in the mean frame [m].
        phi: its relative rotation.
        F: (3,) load beyond it [N].
        S: (3, 3) Σ ρ Fᵀ of it, ρ from its second end [N m].
        B: (3, 6) output.
        C: (6, 6) output, symmetric.
    """
    back, half = conjugate(frame), scale(0.5, phi)
    turn = from_rotation_vector(half)
    f, r = rotate(back, row(F.reshape(1, 3), 0)), rotate(turn, u)
    s = np.empty((3, 3))  # S in the frame
    for j in range(3):
        column = rotate(back, (S[0, j], S[1, j], S[2, j]))
        s[0, j], s[1, j], s[2, j] = column
    for i in range(3):
        s[i, 0], s[i, 1], s[i, 2] = rotate(back, (s[i, 0], s[i, 1], s[i, 2]))
    trace = s[0, 0] + s[1, 1] + s[2, 2]
    theta_h, theta = np.empty((3, 3)), np.empty((3, 3))  # columns: spins of unit changes of φ
    moved = np.empty((6, 3))  # V of each strain
    for i in range(3):
        unit = unit_vector(i)
        h, e = spin(half, scale(0.5, unit)), spin(phi, unit)
        along, across = rotate(turn, unit), cross(h, r)
        for k in range(3):
            theta_h[k, i], theta[k, i] = h[k], e[k]
            moved[i, k], moved[3 + i, k] = along[k], across[k]
    for i in range(6):
        b = cross(row(moved, i), f)
        if i >= 3:
            e = (theta[0, i - 3], theta[1, i - 3], theta[2, i - 3])
            b = (
                b[0] + s[0, 0] * e[0] + s[0, 1] * e[1] + s[0, 2] * e[2] - trace * e[0],
                b[1] + s[1, 0] * e[0] + s[1, 1] * e[1] + s[1, 2] * e[2] - trace * e[1],
                b[2] + s[2, 0] * e[0] + s[2, 1] * e[1] + s[2, 2] * e[2] - trace * e[2],
            )
        B[0, i], B[1, i], B[2, i] = rotate(frame, b)
    C[:] = 0.0
    for j in range(3):
        h_j = (theta_h[0, j], theta_h[1, j], theta_h[2, j])
        for i in range(3):
            C[i, 3 + j] = dot(f, cross(h_j, row(moved, i)))
            C[3 + j, i] = C[i, 3 + j]
    add_form(np.outer(np.array(r), np.array(f)), theta_h, C)
    add_form(s, theta, C)
    add_spin_change(cross(r, f), half, 0.25, C)
    moment = (s[1, 2] - s[2, 1], s[2, 0] - s[0, 2], s[0, 1] - s[1, 0])
    add_spin_change(moment, phi, 1.0, C)


@kernel
def add_form(S: Array, theta: Array, C: Array) -> None:
    """Add θᵀ (S − tr(S) I) θ to the block of φ of the symmetric C (6, 6).

    Args:
        S: (3, 3); its symmetric part counts [N m].
        theta: (3, 3) spins of unit changes of φ, in columns.
        C: (6, 6) accumulated.
    """
    trace = S[0, 0] + S[1, 1] + S[2, 2]
    for i in range(3):
        for j in range(3):
            value = 0.0
            for p in range(3):
                value -= trace * theta[p, i] * theta[p, j]
                for q in range(3):
                    value += theta[p, i] * 0.5 * (S[p, q] + S[q, p]) * theta[q, j]
            C[3 + i, 3 + j] += value


@kernel
def load_rows(
    strains: Array,
    beams: BeamArrays,
    elements: Ints,
    Q: Array,
    loads: tuple[Array, Array],
    Phi: Array,
    J: Array,
    Y: Array,
) -> None:
    """Rows Y with which the change of the loads' power is −(Φᵀ Y + Yᵀ Φ), over some elements.

    Args:
        strains: (6 e,) natural strains.
        beams: the elements.
        elements: (s,) numbers of the elements that carry loads.
        Q: (n_nodes, 4) rotations.
        loads: F and S of `loads_beyond`.
        Phi: (6 e, r) strain modes.
        J: (6 n_nodes, r) motion of the nodes.
        Y: (6 s, r) output.
    """
    F, S = loads
    B, C = np.empty((3, 6)), np.empty((6, 6))
    for at in range(elements.shape[0]):
        k = elements[at]
        a, b, first = beams.ends[k, 0], beams.ends[k, 1], 6 * k
        u = (strains[first] + beams.length[k], strains[first + 1], strains[first + 2])
        phi = (strains[first + 3], strains[first + 4], strains[first + 5])
        frame = product(quaternion(Q, a), quaternion(beams.axes, k))
        load_terms(frame, u, phi, F[b], S[b], B, C)
        n = 6 * a + 3
        for i in range(6):
            B0, B1, B2 = B[0, i], B[1, i], B[2, i]
            C0, C1, C2 = 0.5 * C[i, 0], 0.5 * C[i, 1], 0.5 * C[i, 2]
            C3, C4, C5 = 0.5 * C[i, 3], 0.5 * C[i, 4], 0.5 * C[i, 5]
            for j in range(Y.shape[1]):
                y = B0 * J[n, j] + B1 * J[n + 1, j] + B2 * J[n + 2, j]
                y += C0 * Phi[first, j] + C1 * Phi[first + 1, j] + C2 * Phi[first + 2, j]
                y += C3 * Phi[first + 3, j] + C4 * Phi[first + 4, j] + C5 * Phi[first + 5, j]
                Y[6 * at + i, j] = y


@kernel
def tension_rows(
    points: Array, first: Ints, owner: Ints, tension: Array, stations: Array, Z: Array, Y: Array
) -> None:
    """Rows Z of the differences of stations and Y with Zᵀ Y the curvature of taut cables.

    Args:
        points: (p, 3) stations [m].
        first: (g,) first station of each segment, the second is the next.
        owner: (g,) cable of each segment.
        tension: (n_a,) [N].
        stations: (3 p, r) motion of the stations.
        Z: (3 g, r) output.
        Y: (3 g, r) output.
    """
    for s in range(first.shape[0]):
        p, z = first[s], 3 * s
        d = subtract(row(points, p + 1), row(points, p))
        ell = dot(d, d) ** 0.5
        pull = max(tension[owner[s]], 0.0)
        k = pull / ell if ell > 0.0 else 0.0
        c = k / (ell * ell) if ell > 0.0 else 0.0
        for j in range(Z.shape[1]):
            D0 = stations[3 * p + 3, j] - stations[3 * p, j]
            D1 = stations[3 * p + 4, j] - stations[3 * p + 1, j]
            D2 = stations[3 * p + 5, j] - stations[3 * p + 2, j]
            along = c * (d[0] * D0 + d[1] * D1 + d[2] * D2)
            Z[z, j], Z[z + 1, j], Z[z + 2, j] = D0, D1, D2
            Y[z, j] = k * D0 - along * d[0]
            Y[z + 1, j] = k * D1 - along * d[1]
            Y[z + 2, j] = k * D2 - along * d[2]
