"""Forces and tangents of sampled elements in reduced coordinates, a block of LANES at a time.

**Corotational laws.** The stress (`tauten.model.tetra.corotational`) is P = 2 μ F + c R with
c = λ tr(S − I) − 2 μ, and F = I + G α is linear in α. So the force and its exact tangent are

    f = −V Gᵀ(2 μ (I + G α)) − V c t                   t = Gᵀ R, the gradient of tr S
    K = V (2 μ Gᵀ G + λ t tᵀ + c aᵀ (tr(S) I − S)⁻¹ a)   a: axial vector of Rᵀ dF − (Rᵀ dF)ᵀ

of which only t (r,) and a (3, r) change: all other terms are summed once. With the rotation held
c (tr(S) I − S)⁻¹ is −μ I.

**Other laws.** f = −V Gᵀ P and K = V Gᵀ C G with the stress and the tangent of `tauten.model.materials`.

Summed over a sample of elements with weights w (`tauten.reduction.state.tetra.ecsw`), V is w V.
"""

from __future__ import annotations

import numpy as np

from tauten.model.materials import EXACT, HELD, WORK, response
from tauten.model.numerics import LANES, Array, Ints, kernel, polar_lanes
from tauten.reduction.state.tetra.arrays import Body, Work


@kernel
def assemble_elements(alpha: Array, exact: bool, body: Body, work: Work) -> int:
    """Subtract the force of the elements from work.force, and write their columns of work.Z and work.Y.

    Args:
        alpha: (r,) [m].
        exact: whether the tangent is the derivative, or positive semidefinite, with rotations held.
        body: the elements.
        work: overwritten.

    Returns:
        Number of columns written.
    """
    F, R, T = np.empty(9 * LANES), np.zeros(9 * LANES), np.empty(7 * LANES)
    P, C = np.empty(9 * LANES), np.empty(81 * LANES)
    width = body.rows * LANES
    for block in range(body.gradient.shape[0]):
        G, first = body.gradient[block], block * width
        deformation_gradients(alpha, G, F)
        if body.turns or not exact:  # else no law reads R
            polar_lanes(F, R)
        if body.corotational:
            stress_and_turning(F, R, body.lame[block], exact, T)
            project(first, G, R, T, body.lame[block], work)
        else:
            laws = (body.kind[block * LANES :], body.constants[block * LANES :])
            respond(F, R, body.volume[block], laws, EXACT if exact else HELD, P, C)
            project_laws(first, G, P, C, work)
    return int(body.gradient.shape[0] * width)


@kernel
def deformation_gradients(alpha: Array, G: Array, F: Array) -> None:
    """F = I + G α of a block.

    Args:
        alpha: (r,) [m].
        G: (r, 9 LANES) of the block.
        F: (9 LANES,) output.
    """
    for m in range(9 * LANES):
        F[m] = 1.0 if (m // LANES) % 4 == 0 else 0.0
    for j in range(G.shape[0]):
        step = alpha[j]
        for m in range(9 * LANES):
            F[m] += step * G[j, m]


@kernel
def stress_and_turning(F: Array, R: Array, lame: Array, exact: bool, T: Array) -> None:
    """The stress coefficients c, and c (tr(S) I − S)⁻¹, or −μ I with rotations held, times the volume.

    Args:
        F: (9 LANES,) deformation gradients.
        R: (9 LANES,) their rotations.
        lame: (2 LANES,) V λ and V μ [N m].
        exact: whether the tangent includes the change of rotations.
        T: (7 LANES,) output, entries 00, 01, 02, 11, 12, 22 of the symmetric matrix, then c [N m].
    """
    for k in range(LANES):
        F00, F01, F02 = F[k], F[LANES + k], F[2 * LANES + k]
        F10, F11, F12 = F[3 * LANES + k], F[4 * LANES + k], F[5 * LANES + k]
        F20, F21, F22 = F[6 * LANES + k], F[7 * LANES + k], F[8 * LANES + k]
        R00, R01, R02 = R[k], R[LANES + k], R[2 * LANES + k]
        R10, R11, R12 = R[3 * LANES + k], R[4 * LANES + k], R[5 * LANES + k]
        R20, R21, R22 = R[6 * LANES + k], R[7 * LANES + k], R[8 * LANES + k]
        S00 = R00 * F00 + R10 * F10 + R20 * F20
        S11 = R01 * F01 + R11 * F11 + R21 * F21
        S22 = R02 * F02 + R12 * F12 + R22 * F22
        S01 = R00 * F01 + R10 * F11 + R20 * F21
        S02 = R00 * F02 + R10 * F12 + R20 * F22
        S12 = R01 * F02 + R11 * F12 + R21 * F22
        mu = lame[LANES + k]
        c = lame[k] * (S00 + S11 + S22 - 3.0) - 2.0 * mu
        # tr(S) I − S has −S01, −S02, −S12 beside its diagonal
        a, b, d = S11 + S22, S00 + S22, S00 + S11
        C00, C11, C22 = b * d - S12 * S12, a * d - S02 * S02, a * b - S01 * S01
        C01, C02, C12 = S01 * d + S02 * S12, S01 * S12 + b * S02, a * S12 + S01 * S02
        det = a * C00 - S01 * C01 - S02 * C02
        # singular only for inverted elements, which keep the tangent with fixed rotations
        turns = exact and det > 1e-3
        w, held = c / det if turns else 0.0, 0.0 if turns else -mu
        T[k], T[LANES + k], T[2 * LANES + k] = w * C00 + held, w * C01, w * C02
        T[3 * LANES + k], T[4 * LANES + k] = w * C11 + held, w * C12
        T[5 * LANES + k], T[6 * LANES + k] = w * C22 + held, c


@kernel
def project(first: int, G: Array, R: Array, T: Array, lame: Array, work: Work) -> None:
    """The rows t and a of a block and their images; its part of the force that is not linear in α.

    Args:
        first: its first column of Z and Y.
        G: (r, 9 LANES) of the block.
        R: (9 LANES,) rotations.
        T: (7 LANES,) of `stress_and_turning`.
        lame: (2 LANES,) V λ and V μ [N m].
        work: Z, Y and force are written.
    """
    end = first + 4 * LANES
    for j in range(G.shape[0]):
        g, z, y, total = G[j], work.Z[j, first:end], work.Y[j, first:end], 0.0
        for k in range(LANES):
            R00, R01, R02 = R[k], R[LANES + k], R[2 * LANES + k]
            R10, R11, R12 = R[3 * LANES + k], R[4 * LANES + k], R[5 * LANES + k]
            R20, R21, R22 = R[6 * LANES + k], R[7 * LANES + k], R[8 * LANES + k]
            G00, G01, G02 = g[k], g[LANES + k], g[2 * LANES + k]
            G10, G11, G12 = g[3 * LANES + k], g[4 * LANES + k], g[5 * LANES + k]
            G20, G21, G22 = g[6 * LANES + k], g[7 * LANES + k], g[8 * LANES + k]
            t = R00 * G00 + R01 * G01 + R02 * G02 + R10 * G10 + R11 * G11 + R12 * G12
            t += R20 * G20 + R21 * G21 + R22 * G22
            a0 = R02 * G01 - R01 * G02 + R12 * G11 - R11 * G12 + R22 * G21 - R21 * G22
            a1 = R00 * G02 - R02 * G00 + R10 * G12 - R12 * G10 + R20 * G22 - R22 * G20
            a2 = R01 * G00 - R00 * G01 + R11 * G10 - R10 * G11 + R21 * G20 - R20 * G21
            T00, T01, T02 = T[k], T[LANES + k], T[2 * LANES + k]
            T11, T12, T22 = T[3 * LANES + k], T[4 * LANES + k], T[5 * LANES + k]
            z[k], z[LANES + k], z[2 * LANES + k], z[3 * LANES + k] = t, a0, a1, a2
            y[k], y[LANES + k] = lame[k] * t, T00 * a0 + T01 * a1 + T02 * a2
            y[2 * LANES + k] = T01 * a0 + T11 * a1 + T12 * a2
            y[3 * LANES + k] = T02 * a0 + T12 * a1 + T22 * a2
            total += T[6 * LANES + k] * t
        work.force[j] -= total


@kernel
def respond(
    F: Array, R: Array, volume: Array, laws: tuple[Ints, Array], tangent: int, P: Array, C: Array
) -> None:
    """Stresses and tangents of a block of any laws, times the volume.

    Args:
        F: (9 LANES,) deformation gradients.
        R: (9 LANES,) their rotations.
        volume: (LANES,) weighted volumes [m³].
        laws: kind (LANES, …) and constants (LANES, 5) of each element's law.
        tangent: EXACT or HELD.
        P: (9 LANES,) output [N m].
        C: (81 LANES,) output, ∂P_m/∂F_n from (9 m + n) LANES on [N m].
    """
    F_k, R_k, P_k = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    C_k, scratch = np.empty((9, 9)), np.empty(WORK)
    for k in range(LANES):
        for m in range(9):
            F_k[m // 3, m % 3], R_k[m // 3, m % 3] = F[m * LANES + k], R[m * LANES + k]
        response(laws[0][k], laws[1][k], F_k, R_k, tangent, P_k, C_k, scratch)
        for m in range(9):
            P[m * LANES + k] = volume[k] * P_k[m // 3, m % 3]
            for n in range(9):
                C[(9 * m + n) * LANES + k] = volume[k] * C_k[m, n]


@kernel
def project_laws(first: int, G: Array, P: Array, C: Array, work: Work) -> None:
    """The force of a block, and the images V C G of its rows G.

    Args:
        first: its first column of Y.
        G: (r, 9 LANES) of the block.
        P: (9 LANES,) of `respond`.
        C: (81 LANES,) of `respond`.
        work: Y and force are written.
    """
    for j in range(G.shape[0]):
        g, total = G[j], 0.0
        for m in range(9 * LANES):
            total += P[m] * g[m]
        work.force[j] -= total
        for m in range(9):
            begin = first + m * LANES
            c, y = C[9 * m * LANES : 9 * (m + 1) * LANES], work.Y[j, begin : begin + LANES]
            for k in range(LANES):
                value = c[k] * g[k] + c[LANES + k] * g[LANES + k]
                value += c[2 * LANES + k] * g[2 * LANES + k] + c[3 * LANES + k] * g[3 * LANES + k]
                value += c[4 * LANES + k] * g[4 * LANES + k] + c[5 * LANES + k] * g[5 * LANES + k]
                value += c[6 * LANES + k] * g[6 * LANES + k] + c[7 * LANES + k] * g[7 * LANES + k]
                y[k] = value + c[8 * LANES + k] * g[8 * LANES + k]
