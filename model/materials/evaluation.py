"""Energy, stress and tangent of a density at one deformation gradient.

With G = cof F, B = F Fᵀ, C = FᵀF and E_m = [e_m] R (the cross product with e_m after R), the derivatives of
the invariants by F are

    S:  R          dR/dF = Σ_mp T_mp E_m ⊗ E_p,  T = R (tr(S) I − S)⁻¹ Rᵀ, here S = RᵀF
    I₁: 2 F        2 I
    I₂: 2 (I₁ F − F C) = Y
        4 F ⊗ F + 2 (I₁ δ_ik δ_JL − δ_ik C_JL − F_iL F_kJ − B_ik δ_JL)
    J:  G          ε_ikm ε_JLn F_mn

and the stress and tangent of a density in these invariants follow by the chain rule.
"""

from __future__ import annotations

import numpy as np

from tauten.model.materials.densities import COROTATIONAL, density
from tauten.model.materials.projection import principal_frames, project_exact, projected_tangent
from tauten.model.numerics import Array, kernel

NO_TANGENT, EXACT, PROJECTED = 0, 1, 2
# Of the unstrained solid, carried along with the element; damping is proportional to it.
MATERIAL = 3
WORK = 32  # numbers of scratch that `response` needs
SINGULAR = 1e-9  # det(tr(S) I − S) below which the rotation of F is not unique


@kernel
def response(
    kind: int, c: Array, F: Array, R: Array, tangent: int, P: Array, C: Array, work: Array
) -> float:
    """Energy density, stress and tangent.

    Args:
        kind: the density, see `densities.density`.
        c: (7,) its constants, λ and μ [Pa].
        F: (3, 3) deformation gradient.
        R: (3, 3) rotation of its polar decomposition, see `polar_rotations`.
        tangent: NO_TANGENT, EXACT, PROJECTED (positive semidefinite) or MATERIAL (positive semidefinite
            too, see `material_tangent`).
        P: (3, 3) output, ∂ψ/∂F [Pa].
        C: (9, 9) output, ∂P_iJ/∂F_kL in row 3 i + J and column 3 k + L [Pa]; left alone without tangent.
        work: (WORK,) overwritten.

    Returns:
        ψ [Pa].
    """
    stress(kind, c, F, R, P, work)
    if tangent != NO_TANGENT:
        tangent_at(kind, c, F, R, tangent, C, work)
    return float(work[0])


@kernel
def stress(kind: int, c: Array, F: Array, R: Array, P: Array, work: Array) -> None:
    """The stress of `response`, and in `work` what `tangent_at` needs.

    Args:
        kind: the density.
        c: (7,) its constants, λ and μ [Pa].
        F: (3, 3) deformation gradient.
        R: (3, 3) rotation of its polar decomposition.
        P: (3, 3) output, ∂ψ/∂F [Pa].
        work: (WORK,) output: ψ and its derivatives, the invariants, gradients of J and I₂.
    """
    d, I = work[0:10], work[10:14]  # noqa: E741
    G, Y = work[14:23], work[23:32]
    invariants(F, R, G, I)
    density(kind, c, I, d)
    for i in range(3):
        for j in range(3):
            P[i, j] = d[1] * R[i, j] + 2.0 * d[2] * F[i, j] + d[4] * G[3 * i + j]
    if d[3] != 0.0 or d[8] != 0.0:
        gradient_of_I2(F, I[1], Y)
        for i in range(3):
            for j in range(3):
                P[i, j] += d[3] * Y[3 * i + j]
    else:
        Y[:] = 0.0


@kernel
def tangent_at(
    kind: int, c: Array, F: Array, R: Array, tangent: int, C: Array, work: Array
) -> None:
    """A tangent of `response` where the stress is known.

    Args:
        kind: the density.
        c: (7,) its constants, λ and μ [Pa].
        F: (3, 3) deformation gradient.
        R: (3, 3) rotation of its polar decomposition.
        tangent: EXACT, PROJECTED or MATERIAL.
        C: (9, 9) output [Pa].
        work: (WORK,) of `stress`.
    """
    d, G, Y = work[0:10], work[14:23], work[23:32]
    if tangent == EXACT:
        exact_tangent(d, F, R, G, Y, C)
    elif tangent == MATERIAL:
        material_tangent(c[5], c[6], R if kind == COROTATIONAL else F, C)
    elif kind == COROTATIONAL:
        projected_tangent(d, F, R, C)
    else:
        frames = np.empty((3, 3, 3))
        exact_tangent(d, F, R, G, Y, C)
        principal_frames(F, R, frames[0], frames[1], frames[2, 0])
        project_exact(d, frames[0], frames[1], frames[2, 0], C)


@kernel
def material_tangent(lam: float, mu: float, M: Array, C: Array) -> None:
    """The stress M (λ tr(E) I + 2 μ E), E = sym(Mᵀ dF): the stiffness of the unstrained solid carried by M.

    With M = F the strain rate E = sym(FᵀḞ) is that of Green and Lagrange, which no rigid motion changes: the
    damping of Kelvin and Voigt. With the rotation R instead, as corotational laws have it, E is that of the
    turned element; a spin of a stretched one changes it by the differences of its stretches.

    Args:
        lam: λ [Pa].
        mu: μ [Pa].
        M: (3, 3) F, or R.
        C: (9, 9) output [Pa].
    """
    for m in range(9):
        i, J = m // 3, m % 3
        for n in range(9):
            k, L = n // 3, n % 3
            C[m, n] = lam * M[i, J] * M[k, L] + mu * M[i, L] * M[k, J]
            if J == L:
                C[m, n] += mu * (M[i, 0] * M[k, 0] + M[i, 1] * M[k, 1] + M[i, 2] * M[k, 2])


@kernel
def invariants(F: Array, R: Array, G: Array, I: Array) -> None:  # noqa: E741
    """S, I₁, I₂ and J into I (4,), the cofactor matrix into G (9,).

    Args:
        F: (3, 3) deformation gradient.
        R: (3, 3) its rotation.
        G: (9,) output.
        I: (4,) output: tr S, I₁, I₂ and J.
    """
    cofactor_entries(F, G)
    I[:] = 0.0
    for i in range(3):
        for j in range(3):
            m = 3 * i + j
            I[0] += R[i, j] * F[i, j]
            I[1] += F[i, j] * F[i, j]
            I[2] += G[m] * G[m]
    I[3] = F[0, 0] * G[0] + F[0, 1] * G[1] + F[0, 2] * G[2]


@kernel
def cofactor_entries(F: Array, G: Array) -> None:
    """Cofactor matrix of F (3, 3) into G (9,), row by row."""
    for i in range(3):
        i1, i2 = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            j1, j2 = (j + 1) % 3, (j + 2) % 3
            G[3 * i + j] = F[i1, j1] * F[i2, j2] - F[i1, j2] * F[i2, j1]


@kernel
def gradient_of_I2(F: Array, I1: float, Y: Array) -> None:
    """2 (I₁ F − F FᵀF) into Y (9,), row by row.

    Args:
        F: (3, 3) deformation gradient.
        I1: first invariant I₁.
        Y: (9,) output.
    """
    for i in range(3):
        b0 = F[i, 0] * F[0, 0] + F[i, 1] * F[0, 1] + F[i, 2] * F[0, 2]  # row i of F Fᵀ
        b1 = F[i, 0] * F[1, 0] + F[i, 1] * F[1, 1] + F[i, 2] * F[1, 2]
        b2 = F[i, 0] * F[2, 0] + F[i, 1] * F[2, 1] + F[i, 2] * F[2, 2]
        for j in range(3):
            Y[3 * i + j] = 2.0 * (I1 * F[i, j] - b0 * F[0, j] - b1 * F[1, j] - b2 * F[2, j])


@kernel
def exact_tangent(d: Array, F: Array, R: Array, G: Array, Y: Array, C: Array) -> None:
    """∂²ψ/∂F² into C (9, 9) from the derivatives d of ψ and the gradients G and Y of J and I₂.

    Args:
        d: derivatives of ψ [Pa].
        F: (3, 3) deformation gradient.
        R: (3, 3) its rotation.
        G: (9,) gradient of J.
        Y: (9,) gradient of I₂.
        C: (9, 9) output [Pa].
    """
    rank_ones(d, F, R, G, Y, C)
    if d[4] != 0.0:
        add_turn_of_cofactor(d[4], F, C)
    if d[3] != 0.0:
        add_curvature_of_I2(2.0 * d[3], F, C)
    if d[1] != 0.0:
        add_turn_of_rotation(d[1], F, R, C)


@kernel
def rank_ones(d: Array, F: Array, R: Array, G: Array, Y: Array, C: Array) -> None:
    """The products of two gradients in `exact_tangent`, and the identity of that of I₁, into C.

    Loops of three become straight code; those of nine take three times as long.

    Args:
        d: derivatives of ψ [Pa].
        F: (3, 3) deformation gradient.
        R: (3, 3) its rotation.
        G: (9,) gradient of J.
        Y: (9,) gradient of I₂.
        C: (9, 9) output [Pa].
    """
    turns, crosses = d[5] != 0.0, d[8] != 0.0  # whether S and I₂ J have second derivatives
    for i in range(3):
        for J in range(3):
            m = 3 * i + J
            # rank-one parts, gathered by the factor they share
            on_F = 4.0 * (d[6] + d[3]) * F[i, J] + 2.0 * d[7] * G[m]
            on_G = 2.0 * d[7] * F[i, J] + d[8] * Y[m] + d[9] * G[m]
            on_R, on_Y = d[5] * R[i, J], d[8] * G[m]
            for k in range(3):
                for L in range(3):
                    C[m, 3 * k + L] = on_F * F[k, L] + on_G * G[3 * k + L]
            if turns or crosses:
                for k in range(3):
                    for L in range(3):
                        C[m, 3 * k + L] += on_R * R[k, L] + on_Y * Y[3 * k + L]
            C[m, m] += 2.0 * d[2]


@kernel
def add_turn_of_cofactor(factor: float, F: Array, C: Array) -> None:
    """Add factor ε_ikm ε_JLn F_mn.

    Args:
        factor: ∂ψ/∂J [Pa].
        F: (3, 3) deformation gradient.
        C: (9, 9) accumulated [Pa].
    """
    for i in range(3):
        k, m = (i + 1) % 3, (i + 2) % 3
        for J in range(3):
            L, n = (J + 1) % 3, (J + 2) % 3
            value = factor * F[m, n]
            C[3 * i + J, 3 * k + L] += value
            C[3 * k + L, 3 * i + J] += value
            C[3 * i + L, 3 * k + J] -= value
            C[3 * k + J, 3 * i + L] -= value


@kernel
def add_curvature_of_I2(factor: float, F: Array, C: Array) -> None:
    """Add factor (I₁ δ_ik δ_JL − δ_ik C_JL − F_iL F_kJ − B_ik δ_JL).

    Args:
        factor: of the sum [Pa].
        F: (3, 3) deformation gradient.
        C: (9, 9) accumulated [Pa].
    """
    I1 = 0.0
    for i in range(3):
        for j in range(3):
            I1 += F[i, j] * F[i, j]
    for i in range(3):
        for k in range(3):
            rows = F[i, 0] * F[k, 0] + F[i, 1] * F[k, 1] + F[i, 2] * F[k, 2]  # B_ik
            columns = F[0, i] * F[0, k] + F[1, i] * F[1, k] + F[2, i] * F[2, k]  # C_ik
            for J in range(3):
                C[3 * i + J, 3 * k + J] -= factor * rows
                C[3 * J + i, 3 * J + k] -= factor * columns
                for L in range(3):
                    C[3 * i + J, 3 * k + L] -= factor * F[i, L] * F[k, J]
    for m in range(9):
        C[m, m] += factor * I1


@kernel
def add_turn_of_rotation(factor: float, F: Array, R: Array, C: Array) -> None:
    """Add factor Σ_mp T_mp E_m ⊗ E_p; nothing where the rotation is not unique.

    Args:
        factor: of the sum [Pa].
        F: (3, 3) deformation gradient.
        R: (3, 3) its rotation.
        C: (9, 9) accumulated [Pa].
    """
    T, Q = np.empty((3, 3)), np.empty(9)
    trace = 0.0
    for i in range(3):
        for j in range(3):
            trace += R[i, j] * F[i, j]
    # tr(S) I − S turned into space, R S Rᵀ = F Rᵀ
    for i in range(3):
        for j in range(i, 3):
            one = F[i, 0] * R[j, 0] + F[i, 1] * R[j, 1] + F[i, 2] * R[j, 2]
            two = F[j, 0] * R[i, 0] + F[j, 1] * R[i, 1] + F[j, 2] * R[i, 2]
            T[i, j] = -0.5 * (one + two)
            T[j, i] = T[i, j]
        T[i, i] += trace
    cofactor_entries(T, Q)
    det = T[0, 0] * Q[0] + T[0, 1] * Q[1] + T[0, 2] * Q[2]
    if not det > SINGULAR:
        return
    scale = factor / det
    for m in range(3):
        m1, m2 = (m + 1) % 3, (m + 2) % 3
        for p in range(3):
            p1, p2 = (p + 1) % 3, (p + 2) % 3
            t = scale * Q[3 * m + p]
            # E_m has −R[m2] in row m1 and R[m1] in row m2
            for J in range(3):
                for L in range(3):
                    C[3 * m1 + J, 3 * p1 + L] += t * R[m2, J] * R[p2, L]
                    C[3 * m1 + J, 3 * p2 + L] -= t * R[m2, J] * R[p1, L]
                    C[3 * m2 + J, 3 * p1 + L] -= t * R[m1, J] * R[p2, L]
                    C[3 * m2 + J, 3 * p2 + L] += t * R[m1, J] * R[p1, L]
