"""Forces, tangents and energy of sampled elements in reduced coordinates, a block of LANES at a time.

**Corotational laws.** The stress (`tauten.model.tetra.corotational`) is P = 2 μ F + c R with
c = λ tr(S − I) − 2 μ, and F = I + G α is linear in α. So the exact tangent is

    K = V (2 μ Gᵀ G + λ t tᵀ + c aᵀ (tr(S) I − S)⁻¹ a)   a: axial vector of Rᵀ dF − (Rᵀ dF)ᵀ

with t = Gᵀ R, the gradient of tr S. Only t (r,) and a (3, r) change: 2 μ V Gᵀ G is summed once. With the
rotation held c (tr(S) I − S)⁻¹ is −μ I: the stiffness of the material D, and the semidefinite tangent.

**Other laws.** f = −V Gᵀ P and K = V Gᵀ C G with the stress and the tangent of `tauten.model.materials`, and
D with its `material_tangent`.

Summed over a sample of elements with weights w (`tauten.reduction.state.tetra.ecsw`), V is w V.
"""

from __future__ import annotations

import numpy as np

from tauten.model.materials import (
    COROTATIONAL,
    EXACT,
    PROJECTED,
    WORK,
    stress,
    tangent_at,
)
from tauten.model.numerics import LANES, Array, Ints, kernel, polar_lanes
from tauten.reduction.state.tetra.arrays import Response, SampledElements, Work
from tauten.reduction.state.tetra.carried import add_material, carried_stress
from tauten.reduction.state.tetra.product import ROWS, add_symmetric_product


@kernel
def assemble_response(
    alpha: Array, v: Array, load: Array, damped: bool, body: SampledElements, response: Response
) -> None:
    """Forces and tangents of the elements at a state.

    Args:
        alpha: (r,) [m].
        v: (r,) its rate [m/s]; read where damped.
        load: (r,) Φᵀ of gravity and outer forces [N].
        damped: whether D is needed.
        body: the elements.
        response: overwritten, but for the curvature of chambers.
    """
    steps = np.zeros((2 if damped else 1, body.gradient.shape[1]))
    steps[0, : alpha.shape[0]] = alpha
    if damped:
        steps[1, : v.shape[0]] = v
    moved = np.zeros((2, 9 * LANES))
    F, rate, P, Q = moved[0], moved[1], np.empty(9 * LANES), np.zeros(9 * LANES)
    r, worked = alpha.shape[0], np.zeros((2, body.gradient.shape[1]))
    for block in range(body.gradient.shape[0]):
        G, R = body.gradient[block], response.carried[block]
        deform(steps, G, moved)
        if body.turns:  # else no law reads R
            polar_lanes(F, R)
        if body.corotational:
            turning_response(F, R, body.lame[block], P, response.exact[block])
        else:
            laws = (body.kind[block * LANES :], body.constants[block * LANES :])
            respond(F, R, body.volume[block], laws, P, response.exact[block])
        if damped:
            carried_stress(rate, R, body.lame[block], Q)
        add_work(P, Q, G, worked)
    response.force[:] = load - worked[0, :r]
    response.resisting[:] = worked[1, :r]


@kernel
def add_elements(
    shares: tuple[float, float], exact: bool, response: Response, body: SampledElements, work: Work
) -> None:
    """Add a sum of the stiffness of the material D and the tangent K of the elements to work.lower.

    Of corotational laws the constant part is left out.

    Args:
        shares: of D and of K.
        exact: whether K is the derivative, or positive semidefinite as D.
        response: of the elements.
        body: the elements.
        work: Z, Y and lower are written.
    """
    of_D, of_K = shares
    if body.corotational and not exact:
        of_D, of_K = of_D + of_K, 0.0
    tangents = response.exact if exact or body.corotational else response.semidefinite
    r = body.stiffness.shape[0]
    C = np.empty(response.exact.shape[1])
    for block in range(body.gradient.shape[0]):
        G = body.gradient[block]
        if body.corotational:
            turning = tangents[block]
            for m in range(6 * LANES):
                C[m] = of_K * turning[m]
            lame = body.lame[block]
            for k in range(LANES):
                held = of_D * lame[LANES + k]
                C[k] -= held
                C[3 * LANES + k] -= held
                C[5 * LANES + k] -= held
            project(r, G, response.carried[block], C, (of_D + of_K) * lame, work)
            add_symmetric_product(work.Z, work.Y, work.lower)
            continue
        C[:] = of_K * tangents[block]
        if of_D != 0.0:
            add_material(of_D, response.carried[block], body.lame[block], C)
        project_laws(r, G, C, work.Y)
        add_symmetric_product(G, work.Y, work.lower)


@kernel
def deform(steps: Array, G: Array, moved: Array) -> None:
    """Deformation gradients I + G α of a block, and rates G α of other α.

    Args:
        steps: (s, R) the α, zero from entry r on; of the first one the deformation gradient is meant.
        G: (R, 9 LANES) of the block.
        moved: (s, 9 LANES) output.
    """
    moved[:] = 0.0
    for i in range(0, 9, 4):
        moved[0, i * LANES : (i + 1) * LANES] = 1.0
    for j in range(0, G.shape[0], ROWS):  # rows of G are read once for all α
        g0, g1, g2, g3 = G[j], G[j + 1], G[j + 2], G[j + 3]
        for i in range(steps.shape[0]):
            a0, a1, a2, a3 = steps[i, j], steps[i, j + 1], steps[i, j + 2], steps[i, j + 3]
            to = moved[i]
            for m in range(9 * LANES):
                to[m] += a0 * g0[m] + a1 * g1[m] + a2 * g2[m] + a3 * g3[m]


@kernel
def add_work(P: Array, Q: Array, G: Array, worked: Array) -> None:
    """Add Gᵀ P and Gᵀ Q of a block, the work of stresses in each mode.

    Args:
        P: (9 LANES,).
        Q: (9 LANES,).
        G: (R, 9 LANES) of the block.
        worked: (2, R) added to.
    """
    for j in range(0, G.shape[0], ROWS):  # stresses are read once for several modes
        g0, g1, g2, g3 = G[j], G[j + 1], G[j + 2], G[j + 3]
        p0 = p1 = p2 = p3 = q0 = q1 = q2 = q3 = 0.0
        for m in range(9 * LANES):
            p0, p1, p2, p3 = (
                p0 + P[m] * g0[m],
                p1 + P[m] * g1[m],
                p2 + P[m] * g2[m],
                p3 + P[m] * g3[m],
            )
            q0, q1, q2, q3 = (
                q0 + Q[m] * g0[m],
                q1 + Q[m] * g1[m],
                q2 + Q[m] * g2[m],
                q3 + Q[m] * g3[m],
            )
        worked[0, j] += p0
        worked[0, j + 1] += p1
        worked[0, j + 2] += p2
        worked[0, j + 3] += p3
        worked[1, j] += q0
        worked[1, j + 1] += q1
        worked[1, j + 2] += q2
        worked[1, j + 3] += q3


@kernel
def turning_response(F: Array, R: Array, lame: Array, P: Array, T: Array) -> None:
    """The stress 2 μ F + c R, and c (tr(S) I − S)⁻¹ of corotational laws, times the volume.

    Args:
        F: (9 LANES,) deformation gradients.
        R: (9 LANES,) their rotations.
        lame: (2 LANES,) V λ and V μ [N m].
        P: (9 LANES,) output, stresses [N m].
        T: (6 LANES,) output, entries 00, 01, 02, 11, 12, 22 of the symmetric matrix [N m].
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
        mu, m2 = lame[LANES + k], 2.0 * lame[LANES + k]
        c = lame[k] * (S00 + S11 + S22 - 3.0) - m2
        # tr(S) I − S has −S01, −S02, −S12 beside its diagonal
        a, b, d = S11 + S22, S00 + S22, S00 + S11
        C00, C11, C22 = b * d - S12 * S12, a * d - S02 * S02, a * b - S01 * S01
        C01, C02, C12 = S01 * d + S02 * S12, S01 * S12 + b * S02, a * S12 + S01 * S02
        det = a * C00 - S01 * C01 - S02 * C02
        # singular only for inverted elements, which keep the tangent with fixed rotations
        turns = det > 1e-3
        w, held = c / det if turns else 0.0, 0.0 if turns else -mu
        T[k], T[LANES + k], T[2 * LANES + k] = w * C00 + held, w * C01, w * C02
        T[3 * LANES + k], T[4 * LANES + k] = w * C11 + held, w * C12
        T[5 * LANES + k] = w * C22 + held
        P[k], P[LANES + k], P[2 * LANES + k] = (
            m2 * F00 + c * R00,
            m2 * F01 + c * R01,
            m2 * F02 + c * R02,
        )
        P[3 * LANES + k], P[4 * LANES + k] = m2 * F10 + c * R10, m2 * F11 + c * R11
        P[5 * LANES + k], P[6 * LANES + k] = m2 * F12 + c * R12, m2 * F20 + c * R20
        P[7 * LANES + k], P[8 * LANES + k] = m2 * F21 + c * R21, m2 * F22 + c * R22


@kernel
def project(r: int, G: Array, R: Array, T: Array, lame: Array, work: Work) -> None:
    """The rows t and a of a block and their images.

    Args:
        r: number of modes.
        G: (R, 9 LANES) of the block.
        R: (9 LANES,) rotations.
        T: (6 LANES,) images of a, entries as of `turning_response`.
        lame: (2 LANES,) images of t, and numbers that are not read.
        work: Z and Y are written.
    """
    for j in range(r):
        g, z, y = G[j], work.Z[j], work.Y[j]
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


@kernel
def respond(
    F: Array, M: Array, volume: Array, laws: tuple[Ints, Array], P: Array, exact: Array
) -> None:
    """Stresses and exact tangents of a block of any laws, times the volume.

    Args:
        F: (9 LANES,) deformation gradients.
        M: (9 LANES,) their rotations, where a law is corotational; F replaces those of other laws.
        volume: (LANES,) weighted volumes [m³].
        laws: kind (LANES, …) and constants (LANES, 7) of each element's law.
        P: (9 LANES,) output [N m].
        exact: (81 LANES,) output, ∂P_m/∂F_n from (9 m + n) LANES on [N m].
    """
    F_k, R_k, P_k = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    C_k, scratch = np.empty((9, 9)), np.empty(WORK)
    for k in range(LANES):
        kind, c = laws[0][k], laws[1][k]
        take_lane(F, k, F_k)
        take_lane(M, k, R_k)
        stress(kind, c, F_k, R_k, P_k, scratch)
        tangent_at(kind, c, F_k, R_k, EXACT, C_k, scratch)
        for m in range(9):
            P[m * LANES + k] = volume[k] * P_k[m // 3, m % 3]
            if kind != COROTATIONAL:
                M[m * LANES + k] = F[m * LANES + k]
        put_lane(C_k, volume[k], k, exact)


@kernel
def assemble_semidefinite(alpha: Array, body: SampledElements, response: Response) -> None:
    """The positive semidefinite tangents of elements that are not all corotational, at an assembled state.

    Args:
        alpha: (r,) [m].
        body: the elements.
        response: `semidefinite` is overwritten.
    """
    step, moved = np.zeros((1, body.gradient.shape[1])), np.empty((1, 9 * LANES))
    step[0, : alpha.shape[0]] = alpha
    F, R = moved[0], np.empty(9 * LANES)
    F_k, R_k, P_k = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    C_k, scratch = np.empty((9, 9)), np.empty(WORK)
    for block in range(body.gradient.shape[0]):
        deform(step, body.gradient[block], moved)
        polar_lanes(F, R)
        for k in range(LANES):
            law = block * LANES + k
            take_lane(F, k, F_k)
            take_lane(R, k, R_k)
            kind, c = body.kind[law], body.constants[law]
            stress(kind, c, F_k, R_k, P_k, scratch)
            tangent_at(kind, c, F_k, R_k, PROJECTED, C_k, scratch)
            put_lane(C_k, body.volume[block, k], k, response.semidefinite[block])


@kernel
def take_lane(lanes: Array, k: int, out: Array) -> None:
    """The matrix of a lane.

    Args:
        lanes: (9 LANES,).
        k: the lane.
        out: (3, 3) output.
    """
    for m in range(9):
        out[m // 3, m % 3] = lanes[m * LANES + k]


@kernel
def put_lane(C: Array, factor: float, k: int, lanes: Array) -> None:
    """A multiple of a matrix into a lane.

    Args:
        C: (9, 9).
        factor: of the matrix.
        k: the lane.
        lanes: (81 LANES,) output.
    """
    for m in range(9):
        for n in range(9):
            lanes[(9 * m + n) * LANES + k] = factor * C[m, n]


@kernel
def project_laws(r: int, G: Array, C: Array, Y: Array) -> None:
    """The images C G of a block's rows G.

    Args:
        r: number of modes.
        G: (R, 9 LANES) of the block.
        C: (81 LANES,) tangents, as of `respond`.
        Y: (R, 9 LANES) output.
    """
    for j in range(r):
        g, y = G[j], Y[j]
        for k in range(LANES):
            g0, g1, g2 = g[k], g[LANES + k], g[2 * LANES + k]
            g3, g4, g5 = g[3 * LANES + k], g[4 * LANES + k], g[5 * LANES + k]
            g6, g7, g8 = g[6 * LANES + k], g[7 * LANES + k], g[8 * LANES + k]
            for m in range(9):
                c = 9 * m * LANES + k
                value = C[c] * g0 + C[c + LANES] * g1 + C[c + 2 * LANES] * g2
                value += C[c + 3 * LANES] * g3 + C[c + 4 * LANES] * g4 + C[c + 5 * LANES] * g5
                value += C[c + 6 * LANES] * g6 + C[c + 7 * LANES] * g7 + C[c + 8 * LANES] * g8
                y[m * LANES + k] = value


@kernel
def sampled_energy(beta: Array, body: SampledElements) -> float:
    """The sum of energy densities times weighted volumes [J].

    Args:
        beta: (R,) [m].
        body: the elements.
    """
    step, moved = np.zeros((1, body.gradient.shape[1])), np.empty((1, 9 * LANES))
    step[0, : beta.shape[0]] = beta
    F, R = moved[0], np.empty(9 * LANES)
    own, turn, P, work = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3)), np.empty(WORK)
    energy = 0.0
    for block in range(body.gradient.shape[0]):
        deform(step, body.gradient[block], moved)
        polar_lanes(F, R)
        for k in range(LANES):
            for i in range(3):
                for j in range(3):
                    own[i, j] = F[(3 * i + j) * LANES + k]
                    turn[i, j] = R[(3 * i + j) * LANES + k]
            law = block * LANES + k
            stress(body.kind[law], body.constants[law], own, turn, P, work)
            energy += body.volume[block, k] * work[0]
    return energy
