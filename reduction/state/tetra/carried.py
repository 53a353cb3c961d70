"""The stiffness of the material, to which damping is proportional, a block of LANES elements at a time.

It is `tauten.model.materials.material_tangent`, the stiffness of the unstrained solid carried along with the
element, which resists strains and no spin.
"""

from __future__ import annotations

from tauten.model.numerics import LANES, Array, kernel


@kernel
def carried_stress(rate: Array, M: Array, lame: Array, Q: Array) -> None:
    """The stress of a rate in `tauten.model.materials.material_tangent`, times the volume.

    Args:
        rate: (9 LANES,) Ḟ.
        M: (9 LANES,) R of corotational laws, F of others.
        lame: (2 LANES,) V λ and V μ [N m].
        Q: (9 LANES,) output.
    """
    for k in range(LANES):
        lam, mu = lame[k], lame[LANES + k]
        M00, M01, M02 = M[k], M[LANES + k], M[2 * LANES + k]
        M10, M11, M12 = M[3 * LANES + k], M[4 * LANES + k], M[5 * LANES + k]
        M20, M21, M22 = M[6 * LANES + k], M[7 * LANES + k], M[8 * LANES + k]
        V00, V01, V02 = rate[k], rate[LANES + k], rate[2 * LANES + k]
        V10, V11, V12 = rate[3 * LANES + k], rate[4 * LANES + k], rate[5 * LANES + k]
        V20, V21, V22 = rate[6 * LANES + k], rate[7 * LANES + k], rate[8 * LANES + k]
        S00 = 2.0 * mu * (M00 * V00 + M10 * V10 + M20 * V20)  # λ tr(E) I + 2 μ E, E = sym(Mᵀ Ḟ)
        S11 = 2.0 * mu * (M01 * V01 + M11 * V11 + M21 * V21)
        S22 = 2.0 * mu * (M02 * V02 + M12 * V12 + M22 * V22)
        S01 = mu * (M00 * V01 + M10 * V11 + M20 * V21 + M01 * V00 + M11 * V10 + M21 * V20)
        S02 = mu * (M00 * V02 + M10 * V12 + M20 * V22 + M02 * V00 + M12 * V10 + M22 * V20)
        S12 = mu * (M01 * V02 + M11 * V12 + M21 * V22 + M02 * V01 + M12 * V11 + M22 * V21)
        spread = M00 * V00 + M10 * V10 + M20 * V20 + M01 * V01 + M11 * V11 + M21 * V21
        spread = lam * (spread + M02 * V02 + M12 * V12 + M22 * V22)
        S00, S11, S22 = S00 + spread, S11 + spread, S22 + spread
        for i in range(3):
            m = 3 * i * LANES + k
            M0, M1, M2 = M[m], M[m + LANES], M[m + 2 * LANES]
            Q[m] = M0 * S00 + M1 * S01 + M2 * S02
            Q[m + LANES] = M0 * S01 + M1 * S11 + M2 * S12
            Q[m + 2 * LANES] = M0 * S02 + M1 * S12 + M2 * S22


@kernel
def add_material(share: float, M: Array, lame: Array, C: Array) -> None:
    """Add a multiple of `tauten.model.materials.material_tangent`, times the volume, to C.

    Args:
        share: the multiple.
        M: (9 LANES,) R of corotational laws, F of others.
        lame: (2 LANES,) V λ and V μ [N m].
        C: (81 LANES,) ∂P_m/∂F_n from (9 m + n) LANES on, added to [N m].
    """
    for m in range(9):
        i, J = m // 3, m % 3
        for n in range(9):
            k, L = n // 3, n % 3
            c = C[(9 * m + n) * LANES : (9 * m + n + 1) * LANES]
            for lane in range(LANES):
                lam, mu = share * lame[lane], share * lame[LANES + lane]
                value = lam * M[m * LANES + lane] * M[n * LANES + lane]
                value += mu * M[(3 * i + L) * LANES + lane] * M[(3 * k + J) * LANES + lane]
                if J == L:
                    product = M[3 * i * LANES + lane] * M[3 * k * LANES + lane]
                    for a in range(1, 3):
                        product += M[(3 * i + a) * LANES + lane] * M[(3 * k + a) * LANES + lane]
                    value += mu * product
                c[lane] += value
