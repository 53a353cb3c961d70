"""How the turning of a tree of beams changes the power of loads: second derivatives of loaded points.

Loads are forces on points that move with the nodes. The points beyond an element have, in the frame of its
first end, the positions y = r + ρ with the chord r = T(φ) e of `tauten.model.beams.helix` and ρ
turned by exp(φ). Rates de of its length with stretch and shear and dφ move them by
V + Ω x ρ, and

    V = T de + dT e,   Ω = T dφ                 dT and d²T: first and second change of T with dφ
    ∂²(Σ F·y) = ω·(V x F + A Ω)                                  one turn ω before the element
              + F·(2 dT de + d²T e + T d²e)                      and within the element
              + Ωᵀ A Ω + (Σ ρ x F)·dT dφ,   A = S − tr(S) I,   S = Σ ρ Fᵀ              (B5)

so that F and S, summed over what lies beyond, are all that is needed of it. (Park, Kim and Ploen compute such
derivatives for serial chains: ASME Journal of Mechanical Design 121, 1999.)
"""

from __future__ import annotations

import numpy as np

from tauten.model.beams import (
    BeamArrays,
    along_helix,
    bent_shares,
    chord_change,
    first_derivatives,
    helix_functions,
    offset_slopes,
    second_derivatives,
    strained_length,
    unit_vector,
)
from tauten.model.numerics import (
    Array,
    Ints,
    Vector3,
    add,
    conjugate,
    cross,
    dot,
    kernel,
    product,
    quaternion,
    rotate,
    row,
    scale,
    subtract,
)
from tauten.model.points import Segments, blunted


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
def add_chord_change(f: Vector3, phi: Vector3, e: Vector3, C: Array) -> None:
    """Add f·(2 dT de + d²T e), a quadratic form of (de, dφ), to the symmetric C (6, 6).

    Args:
        f: load beyond the element, in the frame of its first end [N].
        phi: its relative rotation.
        e: its length with stretch and shear [m].
        C: (6, 6) accumulated.
    """
    t = dot(phi, phi) ** 0.5
    _, b, c = helix_functions(t)
    dA, dB, dC = first_derivatives(t)
    ddA, ddB, ddC = second_derivatives(t)
    phi_e, phi_f, e_f, across = dot(phi, e), dot(phi, f), dot(e, f), cross(e, f)
    triple = dot(phi, across)
    p = dA * e_f + dB * triple + dC * phi_e * phi_f
    q = ddA * e_f + ddB * triple + ddC * phi_e * phi_f
    w = add(scale(dB, across), scale(dC, add(scale(phi_f, e), scale(phi_e, f))))
    g = add(scale(dA, f), add(scale(dB, cross(f, phi)), scale(dC * phi_f, phi)))
    for j in range(3):
        turned = cross(f, unit_vector(j))
        for i in range(3):
            value = q * phi[i] * phi[j] + phi[i] * w[j] + w[i] * phi[j]
            value += c * (e[i] * f[j] + f[i] * e[j])
            mixed = g[i] * phi[j] + b * turned[i] + c * phi[i] * f[j]
            if i == j:
                value, mixed = value + p, mixed + c * phi_f
            C[3 + i, 3 + j] += value
            C[i, 3 + j] += mixed
            C[3 + j, i] += mixed


@kernel
def add_spin_change(m: Vector3, phi: Vector3, C: Array) -> None:
    """Add m·dT dφ, a quadratic form of dφ, to the block of φ of the symmetric C (6, 6).

    Args:
        m: moment [N m].
        phi: rotation vector.
        C: (6, 6) accumulated.
    """
    t = dot(phi, phi) ** 0.5
    _, _, c = helix_functions(t)
    dA, dB, dC = first_derivatives(t)
    along, across = dot(phi, m), cross(m, phi)
    for i in range(3):
        for j in range(3):
            b_i = (dA + c) * m[i] + dB * across[i] + dC * along * phi[i]
            b_j = (dA + c) * m[j] + dB * across[j] + dC * along * phi[j]
            value = 0.5 * (phi[i] * b_j + b_i * phi[j])
            if i == j:
                value += c * along
            C[3 + i, 3 + j] += value


@kernel
def load_terms(
    frame: tuple[float, float, float, float],
    e: Vector3,
    phi: Vector3,
    F: Array,
    S: Array,
    B: Array,
    C: Array,
) -> None:
    """The terms of (B5) of one element: ω·B (de, dφ) with a turn ω in space, and the form C of (de, dφ).

    Args:
        frame: rotation of its first end with its axes.
        e: its length with stretch and shear [m].
        phi: its relative rotation.
        F: (3,) load beyond it [N].
        S: (3, 3) Σ ρ Fᵀ of it, ρ from its second end [N m].
        B: (3, 6) output.
        C: (6, 6) output, symmetric.
    """
    back = conjugate(frame)
    f = rotate(back, (F[0], F[1], F[2]))
    s = np.empty((3, 3))  # S in the frame
    for j in range(3):
        column = rotate(back, (S[0, j], S[1, j], S[2, j]))
        s[0, j], s[1, j], s[2, j] = column
    for i in range(3):
        s[i, 0], s[i, 1], s[i, 2] = rotate(back, (s[i, 0], s[i, 1], s[i, 2]))
    trace = s[0, 0] + s[1, 1] + s[2, 2]
    theta = np.empty((3, 3))  # columns: spins of unit changes of φ
    for i in range(3):
        unit = unit_vector(i)
        j_i = along_helix(phi, unit)
        by_strain, by_turn = cross(j_i, f), cross(chord_change(phi, e, unit), f)
        by_turn = (
            by_turn[0] + s[0, 0] * j_i[0] + s[0, 1] * j_i[1] + s[0, 2] * j_i[2] - trace * j_i[0],
            by_turn[1] + s[1, 0] * j_i[0] + s[1, 1] * j_i[1] + s[1, 2] * j_i[2] - trace * j_i[1],
            by_turn[2] + s[2, 0] * j_i[0] + s[2, 1] * j_i[1] + s[2, 2] * j_i[2] - trace * j_i[2],
        )
        B[0, i], B[1, i], B[2, i] = rotate(frame, by_strain)
        B[0, 3 + i], B[1, 3 + i], B[2, 3 + i] = rotate(frame, by_turn)
        theta[0, i], theta[1, i], theta[2, i] = j_i
    C[:] = 0.0
    add_chord_change(f, phi, e, C)
    add_form(s, theta, C)
    moment = (s[1, 2] - s[2, 1], s[2, 0] - s[0, 2], s[0, 1] - s[1, 0])
    add_spin_change(moment, phi, C)


@kernel
def in_strains(
    slopes: tuple[float, float], shares: tuple[float, float], pull: float, B: Array, C: Array
) -> None:
    """Turn the terms of (B5) of (de, dφ) into those of (dε, dφ), (B2) of `tauten.model.beams.elements`.

    Args:
        slopes: see `offset_slopes`.
        shares: see `bent_shares` [1/m].
        pull: the load that de_1 moves [N].
        B: (3, 6) changed.
        C: (6, 6) changed, symmetric.
    """
    for j in range(2):
        for i in range(3):
            B[i, 1 + j] -= slopes[j] * B[i, 0]
        for i in range(6):
            C[i, 1 + j] -= slopes[j] * C[i, 0]
    for j in range(2):
        for i in range(6):
            C[1 + j, i] -= slopes[j] * C[0, i]
        C[1 + j, 1 + j] -= 2.0 * shares[j] * pull


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
        e = strained_length(strains, beams, k)
        phi = (strains[first + 3], strains[first + 4], strains[first + 5])
        frame = product(quaternion(Q, a), quaternion(beams.axes, k))
        load_terms(frame, e, phi, F[b], S[b], B, C)
        pull = dot(rotate(frame, along_helix(phi, unit_vector(0))), row(F, b))
        in_strains(offset_slopes(beams, k, e), bent_shares(beams, k), pull, B, C)
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
def effort_rows(
    points: Array, segments: Segments, effort: Array, stations: Array, Z: Array, Y: Array
) -> None:
    """Rows Z of the differences of stations and Y with Zᵀ Y the curvature of cables under tension.

    Args:
        points: (p, 3) stations [m].
        segments: of g segments, see `Paths.segment_arrays`; the second station is the next.
        effort: (n_a,) [N].
        stations: (3 p, r) motion of the stations.
        Z: (3 g, r) output.
        Y: (3 g, r) output.
    """
    first, owner, shortest = segments
    for s in range(first.shape[0]):
        p, z = first[s], 3 * s
        d = subtract(row(points, p + 1), row(points, p))
        ell = dot(d, d) ** 0.5
        _, slope, curvature = blunted(ell, shortest[s])
        k = effort[owner[s]] * slope
        c = effort[owner[s]] * (slope - curvature) / (ell * ell) if ell > 0.0 else 0.0
        for j in range(Z.shape[1]):
            D0 = stations[3 * p + 3, j] - stations[3 * p, j]
            D1 = stations[3 * p + 4, j] - stations[3 * p + 1, j]
            D2 = stations[3 * p + 5, j] - stations[3 * p + 2, j]
            along = c * (d[0] * D0 + d[1] * D1 + d[2] * D2)
            Z[z, j], Z[z + 1, j], Z[z + 2, j] = D0, D1, D2
            Y[z, j] = k * D0 - along * d[0]
            Y[z + 1, j] = k * D1 - along * d[1]
            Y[z + 2, j] = k * D2 - along * d[2]
