"""Beams in space with large rotations: nodes with position and rotation, constant curvature and more.

The frame of an element is the mean of the rotations R_A and R_B of its ends, with the axes of the element
(along the beam, and the principal axes of its cross-section):

    φ = log(R_Aᵀ R_B)            relative rotation of the ends
    R_e = R_A exp(φ / 2)         the frame
    u = R_eᵀ (x_B − x_A)         the chord in this frame

Rigid motion does not change (u, φ). A beam with the same strains in every cross-section is a helix, and its
chord is the mean of exp(s φ), −½ ≤ s ≤ ½, times the length of the axis with its strains. With θ = |φ| and
n = φ / θ,

    ε = Γ u − (L, 0, 0),   Γ = γ (I − n nᵀ) + n nᵀ = γ I + η φ φᵀ,   γ = (θ/2) / sin(θ/2)

are the stretch and shear of the helix times L: e = Γ u has the offsets e_2, e_3 across the axis. Of an offset
the share β is antisymmetric bending, the rest shear. A chord turned by it from the frame is that of a cubic,
which is longer than the chord, so that the axis is stretched by

    ε = e − (L, 0, 0) + (b_2 e_2² + b_3 e_3², 0, 0),   b = β (1 − 2 β / 5) / L

to second order. Without b an element lengthens under a tension of more than 12 E I / L² for nothing, as it
turns away from its chord. The six numbers (ε, φ) are the natural strains: stretch, two antisymmetric bendings
with shear, torsion, two pure bendings, Argyris' natural modes. They are decoupled, so that the energy

    E = ½ εᵀ D_ε ε + ½ φᵀ D_φ φ                                                   (B1)

with six stiffnesses is, at small φ, that of the exact linear Timoshenko beam, and of Euler and Bernoulli's
when shear is rigid: one element bends as the cubic does, without locking. An arc or a helix is exact with
one element, whatever its angle. With small rotations δa, δb of the ends in this frame,

    δφ = Γ (δb − δa)
    δw = ½ (δa + δb) − ½ τ φ x (δb − δa),   τ = tan(θ/4) / θ      turn of the frame
    δu = δp_B − δp_A + u x δw
    δe = Γ δu + G(φ, u) δφ,   δε = δe + (2 b_2 e_2 δe_2 + 2 b_3 e_3 δe_3, 0, 0)    (B2)
    G(φ, u) = ∂(Γ u)/∂φ = γ' u φᵀ + η (φ·u I + φ uᵀ) + η' (φ·u) φ φᵀ

where a prime is the derivative by θ divided by θ. Forces and the tangent follow by differentiation, the
latter exactly. Increments of rotation are about fixed axes, so that the tangent is symmetric in
equilibrium only; its symmetric part is used (Simo, Computer Methods in Applied Mechanics and Engineering
96, 1992).

Sources: Argyris et al., Computer Methods in Applied Mechanics and Engineering 17/18, 1979 (natural
modes); Crisfield, 81, 1990 (corotational frame in the middle of the end rotations); Sonneville, Cardona
and Brüls, 268, 2014 (helices as elements).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tauten.model.numerics import (
    Array,
    Ints,
    Vector3,
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

# γ = Σ c_k θ^2k, the series of (θ/2) / sin(θ/2)
C1, C2, C3, C4 = 1.0 / 24.0, 7.0 / 5760.0, 31.0 / 967680.0, 127.0 / 154828800.0
C5, C6 = 73.0 / 3503554560.0, 1414477.0 / 2678117105664000.0
C7, C8 = 8191.0 / 612141052723200.0, 16931177.0 / 49950709902213120000.0

Pair = tuple[float, float]  # for axes 2 and 3


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
def stretch_functions(theta: float) -> tuple[float, float, float, float, float, float]:
    """γ and η = (1 − γ) / θ² of (B1), γ' and η' of (B2), and γ'' and η'', formed alike."""
    t2 = theta * theta
    if theta < 0.3:  # Taylor series, exact to rounding here
        c3 = C3 + t2 * (C4 + t2 * (C5 + t2 * (C6 + t2 * (C7 + t2 * C8))))
        gamma = 1.0 + t2 * (C1 + t2 * (C2 + t2 * c3))
        eta = -C1 - t2 * (C2 + t2 * c3)
        e3 = C3 + t2 * (4 / 3 * C4 + t2 * (5 / 3 * C5 + t2 * (2.0 * C6 + t2 * 7 / 3 * C7)))
        d_gamma = 2.0 * C1 + t2 * (4.0 * C2 + t2 * 6.0 * e3)
        f3 = C3 + t2 * (1.5 * C4 + t2 * (2.0 * C5 + t2 * (2.5 * C6 + t2 * (3.0 * C7))))
        d_eta = -2.0 * C2 - t2 * 4.0 * f3
        g3 = C3 + t2 * (2.0 * C4 + t2 * (10 / 3 * C5 + t2 * (5.0 * C6 + t2 * 7.0 * C7)))
        dd_gamma = 8.0 * C2 + t2 * 24.0 * g3
        h3 = C3 + t2 * (3.0 * C4 + t2 * (6.0 * C5 + t2 * (10.0 * C6 + t2 * (15.0 * C7))))
        return gamma, eta, d_gamma, d_eta, dd_gamma, -8.0 * h3
    sine, cosine = np.sin(0.5 * theta), np.cos(0.5 * theta)
    gamma = 0.5 * theta / sine
    eta = (1.0 - gamma) / t2
    d_gamma = (0.5 / sine - 0.25 * theta * cosine / (sine * sine)) / theta
    d_eta = -(d_gamma + 2.0 * eta) / t2
    second = 0.125 * theta / sine - 0.5 * cosine / (sine * sine)
    second += 0.25 * theta * cosine * cosine / (sine * sine * sine)
    dd_gamma = (second - d_gamma) / t2
    return gamma, eta, d_gamma, d_eta, dd_gamma, -(dd_gamma + 4.0 * d_eta) / t2


@kernel
def turn_functions(theta: float) -> tuple[float, float]:
    """τ of (B2) and its derivative divided by θ."""
    t2 = theta * theta
    if theta < 0.1:  # Taylor series, exact to rounding here
        tau = 0.25 + t2 * (1.0 / 192.0 + t2 * (1.0 / 7680.0 + t2 * 17.0 / 5160960.0))
        return tau, 1.0 / 96.0 + t2 * (1.0 / 1920.0 + t2 * 17.0 / 860160.0)
    tangent = np.tan(0.25 * theta)
    tau = tangent / theta
    return tau, (0.25 * (1.0 + tangent * tangent) - tau) / t2


@kernel
def stretched(u: Vector3, phi: Vector3, gamma: float, eta: float) -> Vector3:
    """Γ u of (B1): stretch and shear, times its length, of the helix whose chord is u.

    Args:
        u: chord in the element's frame [m].
        phi: φ, relative rotation of the ends.
        gamma: γ at |φ|.
        eta: η at |φ|.
    """
    return add(scale(gamma, u), scale(eta * dot(phi, u), phi))


@kernel
def stretch_change(
    u: Vector3, phi: Vector3, dphi: Vector3, eta: float, d_gamma: float, d_eta: float
) -> Vector3:
    """G(φ, u) dφ of (B2), the change of Γ u with φ.

    Args:
        u: chord in the element's frame [m].
        phi: φ, relative rotation of the ends.
        dphi: its change.
        eta: η at |φ|.
        d_gamma: γ' at |φ|.
        d_eta: η' at |φ|.
    """
    along, turned = dot(phi, u), dot(phi, dphi)
    part = add(scale(d_gamma * turned, u), scale(eta * along, dphi))
    return add(part, scale(eta * dot(dphi, u) + d_eta * along * turned, phi))


@kernel
def stretch_moment(
    u: Vector3, phi: Vector3, N: Vector3, eta: float, d_gamma: float, d_eta: float
) -> Vector3:
    """G(φ, u)ᵀ N of (B2).

    Args:
        u: chord in the element's frame [m].
        phi: φ, relative rotation of the ends.
        N: force against stretch and shear [N].
        eta: η at |φ|.
        d_gamma: γ' at |φ|.
        d_eta: η' at |φ|.
    """
    along, position = dot(phi, u), dot(phi, N)
    part = add(scale(eta * along, N), scale(eta * position, u))
    return add(part, scale(d_gamma * dot(u, N) + d_eta * along * position, phi))


@kernel
def bent_shares(beams: BeamArrays, k: int) -> Pair:
    """b_2 and b_3 of an element k [1/m]: β = L² D / 12 D_φ, of the bending of one plane."""
    D, L = beams.D[k], beams.length[k]
    beta_2, beta_3 = L * L * D[1] / (12.0 * D[5]), L * L * D[2] / (12.0 * D[4])
    return beta_2 * (1.0 - 0.4 * beta_2) / L, beta_3 * (1.0 - 0.4 * beta_3) / L


@kernel
def offset_slopes(beams: BeamArrays, k: int, e: Vector3) -> Pair:
    """Stretch of the axis of an element k by its offsets, 2 b_2 e_2 and 2 b_3 e_3.

    Args:
        beams: all elements.
        k: number of this one.
        e: its length with stretch and shear [m].
    """
    b = bent_shares(beams, k)
    return 2.0 * b[0] * e[1], 2.0 * b[1] * e[2]


@kernel
def axis_change(de: Vector3, slopes: Pair) -> Vector3:
    """δε of (B2) of a change δe [m], with the slopes of `offset_slopes`."""
    return de[0] + slopes[0] * de[1] + slopes[1] * de[2], de[1], de[2]


@kernel
def offset_forces(P: Vector3, slopes: Pair) -> Vector3:
    """The forces that do the work on δe that forces P do on δε [N], see `axis_change`."""
    return P[0], P[1] + slopes[0] * P[0], P[2] + slopes[1] * P[0]


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
    start, end, D, rest = beams.ends[k, 0], beams.ends[k, 1], beams.D[k], beams.length[k]
    axes = quaternion(beams.axes, k)
    first = product(quaternion(Q, start), axes)
    relative = product(conjugate(first), product(quaternion(Q, end), axes))
    if relative[0] < 0.0:
        relative = (-relative[0], -relative[1], -relative[2], -relative[3])
    phi = rotation_vector(relative)
    frame = product(first, normalised((1.0 + relative[0], relative[1], relative[2], relative[3])))
    u = rotate(conjugate(frame), subtract(row(x, end), row(x, start)))
    theta = dot(phi, phi) ** 0.5
    gamma, eta, d_gamma, d_eta, dd_gamma, dd_eta = stretch_functions(theta)
    tau, d_tau = turn_functions(theta)
    e = stretched(u, phi, gamma, eta)
    b, slopes = bent_shares(beams, k), offset_slopes(beams, k, e)
    axis = e[0] - rest + 0.5 * (slopes[0] * e[1] + slopes[1] * e[2])
    strained = (D[0] * axis, D[1] * e[1], D[2] * e[2])
    P = offset_forces(strained, slopes)
    bent = (D[3] * phi[0], D[4] * phi[1], D[5] * phi[2])
    N = stretched(P, phi, gamma, eta)  # ∂E for u
    M = add(bent, stretch_moment(u, phi, P, eta, d_gamma, d_eta))  # ∂E for φ
    t = cross(N, u)
    phi_t, phi_M = cross(phi, t), dot(phi, M)
    phi_u, phi_P, u_P = dot(phi, u), dot(phi, P), dot(u, P)
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
        dphi = stretched(turn, phi, gamma, eta)
        de = add(stretched(du, phi, gamma, eta), stretch_change(u, phi, dphi, eta, d_gamma, d_eta))
        changed = axis_change(de, slopes)
        dP = offset_forces((D[0] * changed[0], D[1] * changed[1], D[2] * changed[2]), slopes)
        if exact:
            dP = add(dP, scale(2.0 * strained[0], (0.0, b[0] * de[1], b[1] * de[2])))
        dN = stretched(dP, phi, gamma, eta)
        dM = (D[3] * dphi[0], D[4] * dphi[1], D[5] * dphi[2])
        dM = add(dM, stretch_moment(u, phi, dP, eta, d_gamma, d_eta))
        theta_d = dot(phi, dphi)  # θ dθ
        if exact:
            dN = add(dN, stretch_change(P, phi, dphi, eta, d_gamma, d_eta))
            d_phi_u, d_phi_P = dot(dphi, u) + dot(phi, du), dot(dphi, P)
            factor = d_gamma * dot(du, P) + d_eta * (d_phi_u * phi_P + phi_u * d_phi_P)
            factor += theta_d * (dd_gamma * u_P + dd_eta * phi_u * phi_P)
            dM = add(dM, scale(factor, phi))
            dM = add(dM, scale(d_gamma * u_P + d_eta * phi_u * phi_P, dphi))
            dM = add(dM, scale(d_eta * theta_d * phi_u + eta * d_phi_u, P))
            dM = add(dM, scale(d_eta * theta_d * phi_P + eta * d_phi_P, u))
            dM = add(dM, scale(eta * phi_P, du))
        dt = add(cross(dN, u), scale(s, cross(N, du)))
        dc = add(scale(0.5 * tau, cross(phi, dt)), stretched(dM, phi, gamma, eta))
        if exact:
            dc = add(dc, scale(0.5 * d_tau * theta_d, phi_t))
            dc = add(dc, scale(0.5 * tau, cross(dphi, t)))
            dc = add(dc, stretch_change(M, phi, dphi, eta, d_gamma, d_eta))
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
    return float(0.5 * (dot(strained, (axis, e[1], e[2])) + dot(bent, phi)))


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
