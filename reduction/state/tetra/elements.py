"""Forces and tangents of sampled elements in reduced coordinates.

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

from typing import TypeAlias

import numpy as np

from tauten.model.materials import EXACT, PROJECTED, WORK, response
from tauten.model.numerics import Array, kernel, polar_rotations
from tauten.reduction.state.tetra.arrays import Body, Work

# of a symmetric 3x3 matrix: entries 00, 01, 02, 11, 12, 22
Symmetric: TypeAlias = tuple[float, float, float, float, float, float]


@kernel
def assemble_elements(alpha: Array, exact: bool, body: Body, work: Work) -> int:
    """Subtract the force of the elements from work.force, and write their rows into work.Z and work.Y.

    Args:
        alpha: (r,) [m].
        exact: whether the tangent is the derivative, or positive semidefinite.
        body: the elements.
        work: overwritten.

    Returns:
        Number of rows written.
    """
    np.dot(body.gradient, alpha, work.F.reshape(-1))
    for i in range(3):
        work.F[:, i, i] += 1.0
    n = len(body.volume)
    if body.turns or not exact:
        polar_rotations(work.F, work.R)
    else:
        work.R[:] = 0.0  # no law reads it
    if body.corotational:
        for e in range(n):
            lam, mu = body.constants[e, 0], body.constants[e, 1]
            c, Q = stress_and_turning(work.F[e], work.R[e], lam, mu, exact)
            project(e, body.volume[e], lam, c, work.R[e], Q, body, work)
        return 4 * n
    tangent = EXACT if exact else PROJECTED
    P, C, scratch = np.empty((3, 3)), np.empty((9, 9)), np.empty(WORK)
    for e in range(n):
        response(body.kind[e], body.constants[e], work.F[e], work.R[e], tangent, P, C, scratch)
        project_law(e, body.volume[e], P, C, work)
    return 9 * n


@kernel
def stress_and_turning(
    F: Array, R: Array, lam: float, mu: float, exact: bool
) -> tuple[float, Symmetric]:
    """The stress coefficient c, and c (tr(S) I − S)⁻¹, or −μ I with rotations held.

    Args:
        F: (3, 3) deformation gradient.
        R: (3, 3) its rotation.
        lam: λ [Pa].
        mu: μ [Pa].
        exact: whether the tangent includes the change of rotations.

    Returns:
        c [Pa]; the six entries of the symmetric matrix [Pa].
    """
    S00 = R[0, 0] * F[0, 0] + R[1, 0] * F[1, 0] + R[2, 0] * F[2, 0]
    S11 = R[0, 1] * F[0, 1] + R[1, 1] * F[1, 1] + R[2, 1] * F[2, 1]
    S22 = R[0, 2] * F[0, 2] + R[1, 2] * F[1, 2] + R[2, 2] * F[2, 2]
    S01 = R[0, 0] * F[0, 1] + R[1, 0] * F[1, 1] + R[2, 0] * F[2, 1]
    S02 = R[0, 0] * F[0, 2] + R[1, 0] * F[1, 2] + R[2, 0] * F[2, 2]
    S12 = R[0, 1] * F[0, 2] + R[1, 1] * F[1, 2] + R[2, 1] * F[2, 2]
    c = float(lam * (S00 + S11 + S22 - 3.0) - 2.0 * mu)
    a, b, d = S11 + S22, S00 + S22, S00 + S11  # tr(S) I − S has −S01, −S02, −S12 beside them
    C00, C11, C22 = b * d - S12 * S12, a * d - S02 * S02, a * b - S01 * S01
    C01, C02, C12 = S01 * d + S02 * S12, S01 * S12 + b * S02, a * S12 + S01 * S02
    det = a * C00 - S01 * C01 - S02 * C02
    # singular only for inverted elements, which keep the tangent with fixed rotations
    if not (exact and det > 1e-3):
        return c, (-mu, 0.0, 0.0, -mu, 0.0, -mu)
    w = c / det
    return c, (w * C00, w * C01, w * C02, w * C11, w * C12, w * C22)


@kernel
def project(
    e: int, V: float, lam: float, c: float, R: Array, Q: Symmetric, body: Body, work: Work
) -> None:
    """Rows t and a of element e and their images; its part of the force that is not linear in α.

    Args:
        e: number of the element in the sample.
        V: its weighted volume w V [m³].
        lam: λ [Pa].
        c: stress coefficient of `stress_and_turning` [Pa].
        R: (3, 3) rotation of its deformation gradient.
        Q: symmetric matrix of `stress_and_turning` [Pa].
        body: the elements.
        work: Z, Y and force are written.
    """
    G, Z, Y, force = body.gradient, work.Z, work.Y, work.force
    # scalars, because numba keeps them in registers where it would reload array entries
    R00, R01, R02, R10, R11, R12 = R[0, 0], R[0, 1], R[0, 2], R[1, 0], R[1, 1], R[1, 2]
    R20, R21, R22 = R[2, 0], R[2, 1], R[2, 2]
    Q00, Q01, Q02, Q11, Q12, Q22 = V * Q[0], V * Q[1], V * Q[2], V * Q[3], V * Q[4], V * Q[5]
    Vc, Vl = V * c, V * lam
    g, z = 9 * e, 4 * e
    for j in range(G.shape[1]):
        G00, G01, G02 = G[g, j], G[g + 1, j], G[g + 2, j]
        G10, G11, G12 = G[g + 3, j], G[g + 4, j], G[g + 5, j]
        G20, G21, G22 = G[g + 6, j], G[g + 7, j], G[g + 8, j]
        t = R00 * G00 + R01 * G01 + R02 * G02 + R10 * G10 + R11 * G11 + R12 * G12
        t += R20 * G20 + R21 * G21 + R22 * G22
        a0 = R02 * G01 - R01 * G02 + R12 * G11 - R11 * G12 + R22 * G21 - R21 * G22
        a1 = R00 * G02 - R02 * G00 + R10 * G12 - R12 * G10 + R20 * G22 - R22 * G20
        a2 = R01 * G00 - R00 * G01 + R11 * G10 - R10 * G11 + R21 * G20 - R20 * G21
        force[j] -= Vc * t
        Z[z, j], Z[z + 1, j], Z[z + 2, j], Z[z + 3, j] = t, a0, a1, a2
        Y[z, j] = Vl * t
        Y[z + 1, j] = Q00 * a0 + Q01 * a1 + Q02 * a2
        Y[z + 2, j] = Q01 * a0 + Q11 * a1 + Q12 * a2
        Y[z + 3, j] = Q02 * a0 + Q12 * a1 + Q22 * a2


@kernel
def project_law(e: int, V: float, P: Array, C: Array, work: Work) -> None:
    """The force of element e, and the images V C G of its rows G.

    Args:
        e: number of the element in the sample.
        V: its weighted volume w V [m³].
        P: (3, 3) stress [Pa].
        C: (9, 9) tangent [Pa].
        work: Z begins with G; Y and force are written.
    """
    G, Y, force, g = work.Z, work.Y, work.force, 9 * e
    for m in range(9):
        p = V * P[m // 3, m % 3]
        # scalars, because numba keeps them in registers where it would reload array entries
        C0, C1, C2 = V * C[m, 0], V * C[m, 1], V * C[m, 2]
        C3, C4, C5 = V * C[m, 3], V * C[m, 4], V * C[m, 5]
        C6, C7, C8 = V * C[m, 6], V * C[m, 7], V * C[m, 8]
        for j in range(
            G.shape[1]
        ):  # with the zeros that follow r columns, which makes whole vectors
            y = C0 * G[g, j] + C1 * G[g + 1, j] + C2 * G[g + 2, j]
            y += C3 * G[g + 3, j] + C4 * G[g + 4, j] + C5 * G[g + 5, j]
            y += C6 * G[g + 6, j] + C7 * G[g + 7, j] + C8 * G[g + 8, j]
            Y[g + m, j] = y
        for j in range(force.shape[0]):
            force[j] -= p * G[g + m, j]
