"""Corotational beams in space: nodes with position and rotation, small strains, any motion.

The frame of an element is the mean of the rotations R_A and R_B of its ends, with the axes of the element
(along the beam, and the principal axes of its cross-section):

    φ = log(R_Aᵀ R_B)            relative rotation of the ends
    R_e = R_A exp(φ / 2)         the frame
    u = R_eᵀ (x_B − x_A)         the chord in this frame

Rigid motion does not change (u, φ). The deformations u − (L, 0, 0) and φ are Argyris' natural
modes: stretch, two antisymmetric bendings with shear, torsion, two pure bendings. They
are decoupled, so that the energy

    E = ½ (u − u₀)ᵀ D_u (u − u₀) + ½ φᵀ D_φ φ                                     (B1)

with six stiffnesses is that of the exact linear Timoshenko beam, and of Euler and Bernoulli's when
shear is rigid: one element bends as the cubic does, without locking. With small rotations δa, δb of the
ends in this frame, θ = |φ|, n = φ / θ,

    δφ = Γ (δb − δa),   Γ = γ (I − n nᵀ) + n nᵀ,   γ = (θ/2) / sin(θ/2)
    δw = ½ (δa + δb) − ½ τ φ x (δb − δa),   τ = tan(θ/4) / θ      turn of the frame
    δu = δp_B − δp_A + u x δw                                                     (B2)

Forces and the tangent follow by differentiation, the latter exactly. Increments of rotation are about
fixed axes, so that the tangent is symmetric in equilibrium only; its symmetric part is used (Simo,
Computer Methods in Applied Mechanics and Engineering 96, 1992).

Sources: Argyris et al., Computer Methods in Applied Mechanics and Engineering 17/18, 1979 (natural
modes); Crisfield, 81, 1990 (corotational frame in the middle of the end rotations).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tauten.model.numerics import (
    Array,
    Ints,
    add,
    conjugate,
    cross,
    dot,
    kernel,
    normalised,
    product,
    quaternion,
    rotate,
    rotation_vector,
    row,
    scale,
    subtract,
)

C8 = 127.0 / 154828800.0  # of θ⁸ in γ


class BeamArrays(NamedTuple):
    """The elements of a body. A named tuple, because numba kernels take these as arguments.

    Attributes:
        ends: (e, 2) nodes of each element.
        axes: (e, 4) rotation from an element's axes to those of the nodes at rest, unit quaternions.
        D: (e, 6) stiffnesses of the natural modes, for u [N/m], for φ [N m].
        length: (e,) lengths at rest [m].
    """

    ends: Ints
    axes: Array
    D: Array
    length: Array


@kernel
def angle_functions(theta: float) -> tuple[float, float, float, float, float, float]:
    """γ, η = (1 − γ) / θ², τ of (B2) and their derivatives divided by θ."""
    t2 = theta * theta
    if theta < 0.1:  # Taylor series, exact to rounding here
        gamma = 1.0 + t2 * (1.0 / 24.0 + t2 * (7.0 / 5760.0 + t2 * 31.0 / 967680.0))
        eta = -1.0 / 24.0 - t2 * (7.0 / 5760.0 + t2 * (31.0 / 967680.0 + t2 * C8))
        tau = 0.25 + t2 * (1.0 / 192.0 + t2 * (1.0 / 7680.0 + t2 * 17.0 / 5160960.0))
        d_gamma = 1.0 / 12.0 + t2 * (7.0 / 1440.0 + t2 * 31.0 / 161280.0)
        d_eta = -7.0 / 2880.0 - t2 * (31.0 / 241920.0 + t2 * 6.0 * C8)
        d_tau = 1.0 / 96.0 + t2 * (1.0 / 1920.0 + t2 * 17.0 / 860160.0)
        return gamma, eta, tau, d_gamma, d_eta, d_tau
    sine, cosine = np.sin(0.5 * theta), np.cos(0.5 * theta)
    gamma = 0.5 * theta / sine
    eta = (1.0 - gamma) / t2
    tangent = np.tan(0.25 * theta)
    tau = tangent / theta
    d_gamma = (0.5 / sine - 0.25 * theta * cosine / (sine * sine)) / theta
    d_eta = -(d_gamma + 2.0 * eta) / t2
    d_tau = (0.25 * (1.0 + tangent * tangent) - tau) / t2
    return gamma, eta, tau, d_gamma, d_eta, d_tau


@kernel
def element(
    x: Array, Q: Array, beams: BeamArrays, k: int, exact: bool, force: Array, K: Array
) -> float:
    """Energy [J], forces and tangent of one element.

    Args:
        x: (n_nodes, 3) positions [m].
        Q: (n_nodes, 4) rotations of the nodes, unit quaternions.
        beams: all elements.
        k: number of this one.
        exact: with the terms of the tangent that stress brings, which may make it indefinite.
        force: (12,) filled with force and moment on a, then on b: −∂E.
        K: (12, 12) filled with −∂force, symmetric part.
    """
    a, b, D, rest = beams.ends[k, 0], beams.ends[k, 1], beams.D[k], beams.length[k]
    e = quaternion(beams.axes, k)
    first = product(quaternion(Q, a), e)
    relative = product(conjugate(first), product(quaternion(Q, b), e))
    if relative[0] < 0.0:
        relative = (-relative[0], -relative[1], -relative[2], -relative[3])
    phi = rotation_vector(relative)
    frame = product(first, normalised((1.0 + relative[0], relative[1], relative[2], relative[3])))
    u = rotate(conjugate(frame), subtract(row(x, b), row(x, a)))
    theta = dot(phi, phi) ** 0.5
    gamma, eta, tau, d_gamma, d_eta, d_tau = angle_functions(theta)
    N = (D[0] * (u[0] - rest), D[1] * u[1], D[2] * u[2])
    M = (D[3] * phi[0], D[4] * phi[1], D[5] * phi[2])
    t = cross(N, u)
    phi_t, phi_M = cross(phi, t), dot(phi, M)
    # half the moments on b minus those on a
    c = add(scale(0.5 * tau, phi_t), add(scale(gamma, M), scale(eta * phi_M, phi)))
    g = (N, add(scale(0.5, t), c), subtract(scale(0.5, t), c))  # ∂E for p_B, b, a
    s = 1.0 if exact else 0.0
    zero, identity = (0.0, 0.0, 0.0), np.eye(3)
    for j in range(12):
        unit = row(identity, j % 3)
        dp = unit if j // 3 == 2 else (scale(-1.0, unit) if j // 3 == 0 else zero)
        da = unit if j // 3 == 1 else zero
        db = unit if j // 3 == 3 else zero
        turn = subtract(db, da)
        w = subtract(scale(0.5, add(da, db)), scale(0.5 * tau, cross(phi, turn)))
        du = add(dp, cross(u, w))
        along = dot(phi, turn)
        dphi = add(scale(gamma, turn), scale(eta * along, phi))
        dN = (D[0] * du[0], D[1] * du[1], D[2] * du[2])
        dM = (D[3] * dphi[0], D[4] * dphi[1], D[5] * dphi[2])
        dt = add(cross(dN, u), scale(s, cross(N, du)))
        dc = add(scale(0.5 * tau, cross(phi, dt)), scale(gamma, dM))
        dc = add(dc, scale(eta * dot(phi, dM), phi))
        if exact:
            theta_d = dot(phi, dphi)  # θ dθ
            dc = add(dc, scale(0.5 * d_tau * theta_d, phi_t))
            dc = add(dc, scale(0.5 * tau, cross(dphi, t)))
            dc = add(dc, scale(d_gamma * theta_d, M))
            dc = add(dc, scale(d_eta * theta_d * phi_M, phi))
            dc = add(dc, scale(eta, add(scale(phi_M, dphi), scale(dot(dphi, M), phi))))
        # derivatives of forces seen from outside turn with the frame
        dforce = add(dN, scale(s, cross(w, g[0])))
        db_moment = add(add(scale(0.5, dt), dc), scale(s, cross(w, g[1])))
        da_moment = add(subtract(scale(0.5, dt), dc), scale(s, cross(w, g[2])))
        for i in range(3):
            K[i, j], K[6 + i, j] = -dforce[i], dforce[i]
            K[3 + i, j], K[9 + i, j] = da_moment[i], db_moment[i]
    to_outside(frame, K)
    N_out, b_out, a_out = rotate(frame, g[0]), rotate(frame, g[1]), rotate(frame, g[2])
    for i in range(3):
        force[i], force[6 + i] = N_out[i], -N_out[i]
        force[3 + i], force[9 + i] = -a_out[i], -b_out[i]
    return float(0.5 * (N[0] * (u[0] - rest) + N[1] * u[1] + N[2] * u[2] + dot(M, phi)))


@kernel
def to_outside(frame: tuple[float, float, float, float], K: Array) -> None:
    """Turn the blocks of K (12, 12) from a frame to the outside and take the symmetric part."""
    for j in range(12):
        for block in range(4):
            i = 3 * block
            K[i, j], K[i + 1, j], K[i + 2, j] = rotate(frame, (K[i, j], K[i + 1, j], K[i + 2, j]))
    for i in range(12):
        for block in range(4):
            j = 3 * block
            K[i, j], K[i, j + 1], K[i, j + 2] = rotate(frame, (K[i, j], K[i, j + 1], K[i, j + 2]))
    for i in range(12):
        for j in range(i):
            mean = 0.5 * (K[i, j] + K[j, i])
            K[i, j], K[j, i] = mean, mean


@kernel
def assemble_beams(
    x: Array,
    Q: Array,
    beams: BeamArrays,
    exact: bool,
    blocks: tuple[Ints, Ints],
    force: Array,
    K: Array,
) -> float:
    """Add the internal forces and the tangent of all elements; returns their energy [J].

    Args:
        x: (n_nodes, 3) positions [m].
        Q: (n_nodes, 4) rotations, unit quaternions.
        beams: all elements.
        exact: see `element`.
        blocks: slot (e, 4, 4) and column_length (e, 4) of the 3x3 blocks, see `Pattern.blocks`; position
            and rotation of node i are the groups 2 i and 2 i + 1 of unknowns.
        force: (2 n_nodes, 3) forces [N] and moments [N m], added to.
        K: (nnz,) CSC values of −∂force, added to.
    """
    energy, f, part = 0.0, np.empty(12), np.empty((12, 12))
    slot, column_length = blocks
    for k in range(beams.ends.shape[0]):
        a, b = beams.ends[k]
        energy += element(x, Q, beams, k, exact, f, part)
        for i in range(6):
            force[2 * a + i // 3, i % 3] += f[i]
            force[2 * b + i // 3, i % 3] += f[6 + i]
        for p in range(4):
            for q in range(4):
                if slot[k, p, q] < 0:
                    continue
                for j in range(3):
                    for i in range(3):
                        place = slot[k, p, q] + j * column_length[k, q] + i
                        K[place] += part[3 * p + i, 3 * q + j]
    return energy
