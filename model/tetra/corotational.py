"""Corotational elements with one point of quadrature: energy, nodal forces and tangent, LANES at a time.

Per element with the volume V, the gradient F = Σ x_a g_aᵀ and its polar rotation R:

    ψ   = μ |F − R|² + λ/2 t²,   t = tr(RᵀF) − 3
    P   = 2 μ (F − R) + λ t R                                            first Piola-Kirchhoff stress
    f_a = −V P g_a                                                       nodal force
    K_ab = V (λ g̃_a g̃_bᵀ + 2 μ (g̃_a·g̃_b) I − [g̃_a]ᵀ T [g̃_b]),  g̃ = R g,  [g] z = g × z
    T   = (2 μ − λ t) (tr(S) I − S)⁻¹,  S = sym(F Rᵀ)                    what turns with R

T = μ I is the tangent with the rotation held, 2 μ (g̃_a·g̃_b) I − μ [g̃_a]ᵀ [g̃_b] = μ (g̃_b g̃_aᵀ + (g̃_a·g̃_b) I),
which is positive semidefinite for every deformation. With the eigenvalues of T limited to μ the tangent is
the nearest positive semidefinite one, because those of its twists are 2 μ − 2 T.
(Müller and Gross, Interactive Virtual Materials, 2004; rotation derivative: McAdams et al., Efficient
Elasticity for Character Skinning with Contact and Collisions, 2011; eigenvalues: Smith, de Goes and Kim,
Analytic Eigensystems for Isotropic Distortion Energies, 2019.)

Layout: a work array holds LANES elements, entry k of all of them in a row, at k LANES to (k + 1) LANES − 1.
Loops over these are of constant length over constant strides and become vector instructions.
"""

from __future__ import annotations

import numpy as np

from tauten.model.materials import MATERIAL, NO_TANGENT, PROJECTED, symmetric_eigen
from tauten.model.numerics import LANES, Array, Ints, kernel, polar_lanes

SINGULAR = 1e-3  # det(tr(S) I − S) up to which, past inversion, the tangent has its rotation held


@kernel
def assemble_corotational(
    x: Array,
    elements: tuple[Ints, Array, Array],
    tangent: int,
    slot: Ints,
    force: Array,
    blocks: Array,
    material: Array,
) -> float:
    """Add internal forces to `force` (n_nodes, 3) and tangents to `blocks` and `material` (m, 9).

    Args:
        x: (n_nodes, 3) positions [m].
        elements: nodes (e, s), ascending in each element, gradients of their shape functions at rest
            (e, s, 3) [1/m], and V λ and V μ (e, 2) [N m].
        tangent: NO_TANGENT, EXACT, PROJECTED (positive semidefinite) or MATERIAL (rotation held).
        slot: (e, s (s + 1) / 2) numbers of the blocks, see `lower_blocks`; not read without tangent.
        force: output, accumulated [N].
        blocks: output, accumulated [N/m].
        material: output, accumulated: the tangent MATERIAL in the same pass [N/m]; without entries (0, 9): it
            is not wanted.

    Returns:
        The elastic energy [J].
    """
    nodes, gradients, stiffness = elements
    n, s = nodes.shape
    F, R, P = np.empty(9 * LANES), np.empty(9 * LANES), np.empty(9 * LANES)
    T, B, psi = np.empty(6 * LANES), np.empty(9 * LANES), np.empty(LANES)
    lam, mu = np.empty(LANES), np.empty(LANES)
    g, M = np.empty(3 * s * LANES), np.empty(9 * s * LANES)
    energy = 0.0
    for first in range(0, n, LANES):
        count = min(LANES, n - first)
        for lane in range(LANES):  # lanes past the last element repeat it and are not stored
            e = min(first + lane, n - 1)
            lam[lane], mu[lane] = stiffness[e, 0], stiffness[e, 1]
            load_lane(x, nodes[e], gradients[e], lane, F, g)
        polar_lanes(F, R)
        respond(F, R, lam, mu, tangent, P, T, psi)
        for lane in range(count):
            energy += psi[lane]
        for a in range(s):
            node_force(a, g, P, B)
            subtract_lanes(B, nodes[first : first + count, a], force)
        if tangent == NO_TANGENT:
            continue
        if tangent == PROJECTED:
            limit_turning(count, mu, T)
        for a in range(s):
            turn_gradient(a, R, T, g, M)
        add_pairs((lam, mu), g, M, B, slot[first : first + count], blocks)
        if material.shape[0] > 0:
            add_pairs((lam, mu), g, M[:0], B, slot[first : first + count], material)
    return energy


@kernel
def add_pairs(
    lame: tuple[Array, Array], g: Array, M: Array, B: Array, slot: Ints, blocks: Array
) -> None:
    """Add K_ab of all pairs of nodes a ≤ b to the blocks of the tangent.

    Args:
        lame: V λ and V μ (LANES,) [N m].
        g: (3 s LANES,) turned gradients [1/m].
        M: (9 s LANES,) of `turn_gradient` [N]; without entries: rotations are held.
        B: (9 LANES,) overwritten.
        slot: (lanes, s (s + 1) / 2) numbers of the blocks of the lanes in use.
        blocks: (m, 9) output, accumulated [N/m].
    """
    pair, s = 0, len(g) // (3 * LANES)
    for a in range(s):
        for b in range(a, s):
            if len(M) > 0:
                pair_block(a, b, lame[0], lame[1], g, M, B)
            else:
                material_block(a, b, lame[0], lame[1], g, B)
            add_lanes(B, slot[:, pair], blocks)
            pair += 1


@kernel
def load_lane(x: Array, nodes: Ints, gradients: Array, lane: int, F: Array, g: Array) -> None:
    """One element's F and gradients into its lane.

    Args:
        x: (n_nodes, 3) positions [m].
        nodes: (s,) of the element.
        gradients: (s, 3) [1/m].
        lane: number of the lane.
        F: (9 LANES,) output, rows of F one after the other.
        g: (3 s LANES,) output.
    """
    f00 = f01 = f02 = f10 = f11 = f12 = f20 = f21 = f22 = 0.0
    for a in range(nodes.shape[0]):
        x0, x1, x2 = x[nodes[a], 0], x[nodes[a], 1], x[nodes[a], 2]
        g0, g1, g2 = gradients[a, 0], gradients[a, 1], gradients[a, 2]
        f00, f01, f02 = f00 + x0 * g0, f01 + x0 * g1, f02 + x0 * g2
        f10, f11, f12 = f10 + x1 * g0, f11 + x1 * g1, f12 + x1 * g2
        f20, f21, f22 = f20 + x2 * g0, f21 + x2 * g1, f22 + x2 * g2
        k = 3 * a * LANES + lane
        g[k], g[k + LANES], g[k + 2 * LANES] = g0, g1, g2
    F[lane], F[LANES + lane], F[2 * LANES + lane] = f00, f01, f02
    F[3 * LANES + lane], F[4 * LANES + lane], F[5 * LANES + lane] = f10, f11, f12
    F[6 * LANES + lane], F[7 * LANES + lane], F[8 * LANES + lane] = f20, f21, f22


@kernel
def subtract_lanes(f: Array, nodes: Ints, force: Array) -> None:
    """Subtract vectors from forces.

    Args:
        f: (3 LANES,) vectors, the first lanes of which are in use [N].
        nodes: (lanes,) of the vectors.
        force: (n_nodes, 3) output, accumulated [N].
    """
    for lane in range(nodes.shape[0]):
        for i in range(3):
            force[nodes[lane], i] -= f[i * LANES + lane]


@kernel
def add_lanes(B: Array, slot: Ints, blocks: Array) -> None:
    """Add 3x3 blocks to those of the tangent.

    Args:
        B: (9 LANES,) blocks, the first lanes of which are in use [N/m].
        slot: (lanes,) their numbers, −1 where a node is fixed.
        blocks: (m, 9) output, accumulated [N/m].
    """
    for lane in range(slot.shape[0]):
        place = slot[lane]
        if place >= 0:
            for k in range(9):
                blocks[place, k] += B[k * LANES + lane]


@kernel
def respond(
    F: Array, R: Array, lam: Array, mu: Array, tangent: int, P: Array, T: Array, psi: Array
) -> None:
    """Energy, stress, and what turns with the rotation, each times the volume.

    Args:
        F: (9 LANES,) deformation gradients.
        R: (9 LANES,) their rotations.
        lam: (LANES,) V λ [N m].
        mu: (LANES,) V μ [N m].
        tangent: MATERIAL leaves T = μ I.
        P: (9 LANES,) output, stress [N m].
        T: (6 LANES,) output, entries 00, 01, 02, 11, 12, 22 [N m].
        psi: (LANES,) output, energy [J].
    """
    turns = tangent != MATERIAL
    for k in range(LANES):
        a, b, c = F[k], F[LANES + k], F[2 * LANES + k]
        d, e, f = F[3 * LANES + k], F[4 * LANES + k], F[5 * LANES + k]
        g, h, i = F[6 * LANES + k], F[7 * LANES + k], F[8 * LANES + k]
        r0, r1, r2 = R[k], R[LANES + k], R[2 * LANES + k]
        r3, r4, r5 = R[3 * LANES + k], R[4 * LANES + k], R[5 * LANES + k]
        r6, r7, r8 = R[6 * LANES + k], R[7 * LANES + k], R[8 * LANES + k]
        s00 = a * r0 + b * r1 + c * r2
        s11 = d * r3 + e * r4 + f * r5
        s22 = g * r6 + h * r7 + i * r8
        s01 = 0.5 * (a * r3 + b * r4 + c * r5 + d * r0 + e * r1 + f * r2)
        s02 = 0.5 * (a * r6 + b * r7 + c * r8 + g * r0 + h * r1 + i * r2)
        s12 = 0.5 * (d * r6 + e * r7 + f * r8 + g * r3 + h * r4 + i * r5)
        strain = s00 + s11 + s22 - 3.0
        two_mu, p = 2.0 * mu[k], lam[k] * strain
        a, b, c = a - r0, b - r1, c - r2
        d, e, f = d - r3, e - r4, f - r5
        g, h, i = g - r6, h - r7, i - r8
        square = a * a + b * b + c * c + d * d + e * e + f * f + g * g + h * h + i * i
        psi[k] = mu[k] * square + 0.5 * p * strain
        P[k], P[LANES + k] = two_mu * a + p * r0, two_mu * b + p * r1
        P[2 * LANES + k], P[3 * LANES + k] = two_mu * c + p * r2, two_mu * d + p * r3
        P[4 * LANES + k], P[5 * LANES + k] = two_mu * e + p * r4, two_mu * f + p * r5
        P[6 * LANES + k], P[7 * LANES + k] = two_mu * g + p * r6, two_mu * h + p * r7
        P[8 * LANES + k] = two_mu * i + p * r8
        # tr(S) I − S, without −S beside the diagonal
        t00, t11, t22 = s11 + s22, s00 + s22, s00 + s11
        c00, c11, c22 = t11 * t22 - s12 * s12, t00 * t22 - s02 * s02, t00 * t11 - s01 * s01
        c01, c02 = s02 * s12 + s01 * t22, s01 * s12 + s02 * t11
        c12 = s01 * s02 + s12 * t00
        det = t00 * c00 - s01 * c01 - s02 * c02
        inverse = turns and det > SINGULAR
        q = (two_mu - p) / det if inverse else 0.0
        held = 0.0 if inverse else mu[k]
        T[k], T[LANES + k], T[2 * LANES + k] = q * c00 + held, q * c01, q * c02
        T[3 * LANES + k], T[4 * LANES + k] = q * c11 + held, q * c12
        T[5 * LANES + k] = q * c22 + held


@kernel
def limit_turning(count: int, mu: Array, T: Array) -> None:
    """Limit the eigenvalues of T to μ, so that the tangent is positive semidefinite.

    Args:
        count: lanes in use.
        mu: (LANES,) V μ [N m].
        T: (6 LANES,) changed in place [N m].
    """
    S, V = np.empty((3, 3)), np.empty((3, 3))
    for lane in range(count):
        k = 0
        for i in range(3):
            for j in range(i, 3):
                S[i, j] = T[k * LANES + lane]
                S[j, i] = S[i, j]
                k += 1
        symmetric_eigen(S, V)
        k = 0
        for i in range(3):
            for j in range(i, 3):
                total = 0.0
                for p in range(3):
                    total += min(S[p, p], mu[lane]) * V[i, p] * V[j, p]
                T[k * LANES + lane] = total
                k += 1


@kernel
def node_force(a: int, g: Array, P: Array, f: Array) -> None:
    """V P g_a into the first 3 LANES of f.

    Args:
        a: the node, 0 to s − 1.
        g: (3 s LANES,) gradients [1/m].
        P: (9 LANES,) stress times volume [N m].
        f: output [N].
    """
    m = 3 * a * LANES
    for k in range(LANES):
        x, y, z = g[m + k], g[m + LANES + k], g[m + 2 * LANES + k]
        f[k] = P[k] * x + P[LANES + k] * y + P[2 * LANES + k] * z
        f[LANES + k] = P[3 * LANES + k] * x + P[4 * LANES + k] * y + P[5 * LANES + k] * z
        f[2 * LANES + k] = P[6 * LANES + k] * x + P[7 * LANES + k] * y + P[8 * LANES + k] * z


@kernel
def turn_gradient(a: int, R: Array, T: Array, g: Array, M: Array) -> None:
    """g̃_a = R g_a in place, and M_a = T [g̃_a].

    Args:
        a: the node, 0 to s − 1.
        R: (9 LANES,) rotations.
        T: (6 LANES,) what turns with them [N m].
        g: (3 s LANES,) gradients, changed in place [1/m].
        M: (9 s LANES,) output [N].
    """
    n, m = 3 * a * LANES, 9 * a * LANES
    for k in range(LANES):
        x, y, z = g[n + k], g[n + LANES + k], g[n + 2 * LANES + k]
        u = R[k] * x + R[LANES + k] * y + R[2 * LANES + k] * z
        v = R[3 * LANES + k] * x + R[4 * LANES + k] * y + R[5 * LANES + k] * z
        w = R[6 * LANES + k] * x + R[7 * LANES + k] * y + R[8 * LANES + k] * z
        g[n + k], g[n + LANES + k], g[n + 2 * LANES + k] = u, v, w
        t00, t01, t02 = T[k], T[LANES + k], T[2 * LANES + k]
        t11, t12, t22 = T[3 * LANES + k], T[4 * LANES + k], T[5 * LANES + k]
        M[m + k], M[m + LANES + k] = t01 * w - t02 * v, t02 * u - t00 * w
        M[m + 2 * LANES + k] = t00 * v - t01 * u
        M[m + 3 * LANES + k], M[m + 4 * LANES + k] = t11 * w - t12 * v, t12 * u - t01 * w
        M[m + 5 * LANES + k] = t01 * v - t11 * u
        M[m + 6 * LANES + k], M[m + 7 * LANES + k] = t12 * w - t22 * v, t22 * u - t02 * w
        M[m + 8 * LANES + k] = t02 * v - t12 * u


@kernel
def pair_block(a: int, b: int, lam: Array, mu: Array, g: Array, M: Array, B: Array) -> None:
    """K_ab row by row, which is the block of row node b and column node a column by column.

    Args:
        a: the node of the rows of K_ab.
        b: the node of its columns.
        lam: (LANES,) V λ [N m].
        mu: (LANES,) V μ [N m].
        g: (3 s LANES,) turned gradients [1/m].
        M: (9 s LANES,) of `turn_gradient` [N].
        B: (9 LANES,) output [N/m].
    """
    n, o, m = 3 * a * LANES, 3 * b * LANES, 9 * b * LANES
    for k in range(LANES):
        a0, a1, a2 = g[n + k], g[n + LANES + k], g[n + 2 * LANES + k]
        b0, b1, b2 = g[o + k], g[o + LANES + k], g[o + 2 * LANES + k]
        m00, m01, m02 = M[m + k], M[m + LANES + k], M[m + 2 * LANES + k]
        m10, m11, m12 = M[m + 3 * LANES + k], M[m + 4 * LANES + k], M[m + 5 * LANES + k]
        m20, m21, m22 = M[m + 6 * LANES + k], M[m + 7 * LANES + k], M[m + 8 * LANES + k]
        dot = 2.0 * mu[k] * (a0 * b0 + a1 * b1 + a2 * b2)
        b0, b1, b2 = lam[k] * b0, lam[k] * b1, lam[k] * b2
        B[k] = a0 * b0 + dot - (a2 * m10 - a1 * m20)
        B[LANES + k] = a0 * b1 - (a2 * m11 - a1 * m21)
        B[2 * LANES + k] = a0 * b2 - (a2 * m12 - a1 * m22)
        B[3 * LANES + k] = a1 * b0 - (a0 * m20 - a2 * m00)
        B[4 * LANES + k] = a1 * b1 + dot - (a0 * m21 - a2 * m01)
        B[5 * LANES + k] = a1 * b2 - (a0 * m22 - a2 * m02)
        B[6 * LANES + k] = a2 * b0 - (a1 * m00 - a0 * m10)
        B[7 * LANES + k] = a2 * b1 - (a1 * m01 - a0 * m11)
        B[8 * LANES + k] = a2 * b2 + dot - (a1 * m02 - a0 * m12)


@kernel
def material_block(a: int, b: int, lam: Array, mu: Array, g: Array, B: Array) -> None:
    """`pair_block` with the rotation held, V (λ g̃_a g̃_bᵀ + μ (g̃_b g̃_aᵀ + (g̃_a·g̃_b) I)).

    Args:
        a: the node of the rows of K_ab.
        b: the node of its columns.
        lam: (LANES,) V λ [N m].
        mu: (LANES,) V μ [N m].
        g: (3 s LANES,) turned gradients [1/m].
        B: (9 LANES,) output [N/m].
    """
    n, o = 3 * a * LANES, 3 * b * LANES
    for k in range(LANES):
        a0, a1, a2 = g[n + k], g[n + LANES + k], g[n + 2 * LANES + k]
        b0, b1, b2 = g[o + k], g[o + LANES + k], g[o + 2 * LANES + k]
        c0, c1, c2 = mu[k] * a0, mu[k] * a1, mu[k] * a2
        dot = c0 * b0 + c1 * b1 + c2 * b2
        a0, a1, a2 = lam[k] * a0, lam[k] * a1, lam[k] * a2
        B[k] = a0 * b0 + c0 * b0 + dot
        B[LANES + k], B[2 * LANES + k] = a0 * b1 + c1 * b0, a0 * b2 + c2 * b0
        B[3 * LANES + k] = a1 * b0 + c0 * b1
        B[4 * LANES + k] = a1 * b1 + c1 * b1 + dot
        B[5 * LANES + k] = a1 * b2 + c2 * b1
        B[6 * LANES + k], B[7 * LANES + k] = a2 * b0 + c0 * b2, a2 * b1 + c1 * b2
        B[8 * LANES + k] = a2 * b2 + c2 * b2 + dot
