"""Corotational linear tetrahedra: nodal forces and tangent, one pass over the elements.

Per element, with the gradient F = Σ x_a g_aᵀ, its polar rotation R and stretch S = RᵀF:

    P   = R (2 μ (S − I) + λ tr(S − I) I)                       first Piola-Kirchhoff stress
    f_a = −V P g_a                                              nodal force
    K_ab = V (λ g̃_a g̃_bᵀ + μ g̃_b g̃_aᵀ + μ (g̃_a·g̃_b) I),  g̃ = R g   tangent for constant R
    + V/2 [g̃_a]ᵀ G̃ [g̃_b],  G = 2 μ I − 2 (2 μ − λ tr(S − I)) (tr(S) I − S)⁻¹   rotation of R

The first line of the tangent is positive semidefinite for every deformation, as a time step
requires; with the second it is the exact derivative of f, for Newton's method.
(Müller and Gross, Interactive Virtual Materials, 2004; rotation derivative: McAdams et al.,
Efficient Elasticity for Character Skinning with Contact and Collisions, 2011.)
"""

from __future__ import annotations

import numpy as np

from tauten.model.mesh import TetMesh
from tauten.model.numerics import Array, Ints, kernel, polar_rotations


def rest_gradients(mesh: TetMesh) -> Array:
    """Gradients of the four shape functions of each element at rest: (e, 4, 3) [1/m]."""
    corners = mesh.nodes[mesh.tets]  # (e, 4, 3)
    inverse = np.linalg.inv(np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2))  # (e, 3, 3)
    g0 = -inverse.sum(axis=1, keepdims=True)
    return np.ascontiguousarray(np.concatenate([g0, inverse], axis=1))


def lumped_mass(mesh: TetMesh, density: float | Array) -> Array:
    """Nodal masses, with a quarter of every element's mass at each corner: (n_nodes,) [kg].

    Args:
        mesh: the body.
        density: of all elements, or of each (e,) [kg/m³].
    """
    share = np.repeat(density * mesh.volumes / 4.0, 4)
    return np.bincount(mesh.tets.ravel(), share, len(mesh.nodes)).astype(float)


@kernel
def cofactor(F: Array, C: Array) -> float:
    """Cofactor matrix of the 3x3 F into C; returns det F."""
    for i in range(3):
        i1, i2 = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            j1, j2 = (j + 1) % 3, (j + 2) % 3
            C[i, j] = F[i1, j1] * F[i2, j2] - F[i1, j2] * F[i2, j1]
    return float(F[0, 0] * C[0, 0] + F[0, 1] * C[0, 1] + F[0, 2] * C[0, 2])


@kernel
def deformation_gradients(x: Array, tets: Ints, gradients: Array) -> Array:
    """F = Σ x_a g_aᵀ of all elements: (e, 3, 3).

    Args:
        x: (n_nodes, 3) positions [m].
        tets: (e, 4) corners.
        gradients: (e, 4, 3) at rest [1/m].
    """
    F = np.zeros((tets.shape[0], 3, 3))
    for e in range(tets.shape[0]):
        for a in range(4):
            for i in range(3):
                for j in range(3):
                    F[e, i, j] += x[tets[e, a], i] * gradients[e, a, j]
    return F


@kernel
def turning(S: Array, R: Array, lam: float, mu: float, G: Array) -> None:
    """R (2 μ I − 2 (2 μ − λ tr(S − I)) (tr(S) I − S)⁻¹) Rᵀ into G: what a turning R adds.

    Args:
        S: (3, 3) stretch.
        R: (3, 3) rotation.
        lam: λ [Pa].
        mu: μ [Pa].
        G: (3, 3) output [Pa].
    """
    trace = S[0, 0] + S[1, 1] + S[2, 2]
    T = np.empty((3, 3))
    C = np.empty((3, 3))
    for i in range(3):
        for j in range(3):
            T[i, j] = -0.5 * (S[i, j] + S[j, i])
        T[i, i] += trace
    det = cofactor(T, C)
    # (tr(S) I − S) is singular only for elements turned inside out: leave their tangent alone
    scale = 2.0 * (2.0 * mu - lam * (trace - 3.0)) / det if det > 1e-3 else 0.0
    for i in range(3):
        for j in range(3):
            T[i, j] = -scale * (R[i, 0] * C[0, j] + R[i, 1] * C[1, j] + R[i, 2] * C[2, j])
    for i in range(3):
        for j in range(3):
            G[i, j] = T[i, 0] * R[j, 0] + T[i, 1] * R[j, 1] + T[i, 2] * R[j, 2]
        if det > 1e-3:
            G[i, i] += 2.0 * mu


@kernel
def assemble(  # noqa: C901  one flat loop nest is what numba compiles best
    x: Array,
    tets: Ints,
    rest: tuple[Array, Array],
    lame: tuple[float, float],
    exact: bool,
    places: tuple[Ints, Ints],
    force: Array,
    K: Array,
) -> None:
    """Add internal forces to `force` (n_nodes, 3) and the tangent to the CSC values `K` (nnz,).

    Args:
        x: (n_nodes, 3) positions.
        tets: (e, 4) corners.
        rest: gradients (e, 4, 3) [1/m] and volumes (e,) [m³] at rest.
        lame: (λ, μ) [Pa].
        exact: whether the tangent includes the rotation of R.
        places: slot (e, 4, 4), place of block (a, b) in K, −1 where a node is fixed; column length (e, 4),
            entries in each column of node b.
        force: (n_nodes, 3) output, accumulated.
        K: (nnz,) output, accumulated.
    """
    lam, mu = lame
    gradients, volumes = rest
    slot, column_length = places
    S, P, G = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    B = np.empty((3, 3))
    g = np.empty((4, 3))
    all_F = deformation_gradients(x, tets, gradients)  # (e, 3, 3)
    all_R = np.empty_like(all_F)  # (e, 3, 3)
    polar_rotations(all_F, all_R)
    for e in range(tets.shape[0]):
        F, R = all_F[e], all_R[e]
        for i in range(3):
            for j in range(3):
                S[i, j] = R[0, i] * F[0, j] + R[1, i] * F[1, j] + R[2, i] * F[2, j]
        trace = S[0, 0] + S[1, 1] + S[2, 2] - 3.0
        for i in range(3):
            for j in range(3):
                P[i, j] = 2.0 * mu * (F[i, j] - R[i, j]) + lam * trace * R[i, j]
        V = volumes[e]
        for a in range(4):
            for i in range(3):
                g[a, i] = 0.0
                for j in range(3):
                    g[a, i] += R[i, j] * gradients[e, a, j]
                    force[tets[e, a], i] -= V * P[i, j] * gradients[e, a, j]
        if exact:
            turning(S, R, lam, mu, G)
        for a in range(4):
            for b in range(a, 4):
                block(lam, mu, V, g[a], g[b], B)
                if exact:
                    add_turning(0.5 * V, G, g[a], g[b], B)
                scatter(B, slot[e], column_length[e], a, b, K)


@kernel
def block(lam: float, mu: float, V: float, ga: Array, gb: Array, B: Array) -> None:
    """K_ab with the rotation held, into the 3x3 B.

    Args:
        lam: λ [Pa].
        mu: μ [Pa].
        V: volume [m³].
        ga: (3,) turned gradient of node a [1/m].
        gb: (3,) turned gradient of node b [1/m].
        B: (3, 3) output [N/m].
    """
    # scalars, because numba keeps them in registers where it would reload array entries
    a0, a1, a2 = V * ga[0], V * ga[1], V * ga[2]
    b0, b1, b2 = gb[0], gb[1], gb[2]
    dot = mu * (a0 * b0 + a1 * b1 + a2 * b2)
    B[0, 0] = (lam + mu) * a0 * b0 + dot
    B[0, 1] = lam * a0 * b1 + mu * a1 * b0
    B[0, 2] = lam * a0 * b2 + mu * a2 * b0
    B[1, 0] = lam * a1 * b0 + mu * a0 * b1
    B[1, 1] = (lam + mu) * a1 * b1 + dot
    B[1, 2] = lam * a1 * b2 + mu * a2 * b1
    B[2, 0] = lam * a2 * b0 + mu * a0 * b2
    B[2, 1] = lam * a2 * b1 + mu * a1 * b2
    B[2, 2] = (lam + mu) * a2 * b2 + dot


@kernel
def add_turning(scale: float, G: Array, ga: Array, gb: Array, B: Array) -> None:
    """Add scale [g_a]ᵀ G [g_b] to B, where [g] z = g × z.

    Args:
        scale: factor [m³].
        G: (3, 3) of `turning` [Pa].
        ga: (3,) turned gradient of node a [1/m].
        gb: (3,) turned gradient of node b [1/m].
        B: (3, 3) accumulated [N/m].
    """
    a0, a1, a2 = scale * ga[0], scale * ga[1], scale * ga[2]
    b0, b1, b2 = gb[0], gb[1], gb[2]
    for i in range(3):
        # row i of G [g_b]
        t0, t1, t2 = (
            G[i, 1] * b2 - G[i, 2] * b1,
            G[i, 2] * b0 - G[i, 0] * b2,
            G[i, 0] * b1 - G[i, 1] * b0,
        )
        # column i of [g_a]ᵀ
        c0, c1, c2 = 0.0, 0.0, 0.0
        if i == 0:
            c1, c2 = -a2, a1
        elif i == 1:
            c0, c2 = a2, -a0
        else:
            c0, c1 = -a1, a0
        B[0, 0] += c0 * t0
        B[0, 1] += c0 * t1
        B[0, 2] += c0 * t2
        B[1, 0] += c1 * t0
        B[1, 1] += c1 * t1
        B[1, 2] += c1 * t2
        B[2, 0] += c2 * t0
        B[2, 1] += c2 * t1
        B[2, 2] += c2 * t2


@kernel
def scatter(B: Array, slot: Ints, length: Ints, a: int, b: int, K: Array) -> None:
    """Add B to block (a, b) of the CSC values K and, by symmetry, Bᵀ to block (b, a).

    Args:
        B: (3, 3) block [N/m].
        slot: (4, 4) places of the element's blocks in K, −1 where a node is fixed.
        length: (4,) entries in each column of the nodes.
        a: first node, 0 to 3.
        b: second node, a to 3.
        K: (nnz,) accumulated [N/m].
    """
    if slot[a, b] < 0:
        return
    for j in range(3):
        for i in range(3):
            K[slot[a, b] + j * length[b] + i] += B[i, j]
    if a != b:
        for j in range(3):
            for i in range(3):
                K[slot[b, a] + j * length[a] + i] += B[j, i]
