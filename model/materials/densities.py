"""Energy densities of isotropic solids and their derivatives in four invariants of F.

A density is a function ψ of S = σ₁ + σ₂ + σ₃, I₁ = Σ σᵢ², I₂ = Σ_{i<j} σᵢ² σⱼ² and J = σ₁ σ₂ σ₃, where
σᵢ are the principal stretches with the sign of det F on the smallest (so S = tr(RᵀF) with the rotation R
of the polar decomposition, I₁ = |F|², I₂ = |cof F|², J = det F).

    corotational        μ (I₁ − 2 S + 3) + λ/2 (S − 3)²
    stable Neo-Hookean  μ̂/2 (I₁ − 3) + λ̂/2 (J − α)² − μ̂/2 log(I₁ + 1) + const,
                        μ̂ = 4/3 μ, λ̂ = λ + 5/6 μ, α = 1 + 3 μ̂ / (4 λ̂)
    Rivlin              c₁₀ (Ī₁ − 3) + c₂₀ (Ī₁ − 3)² + c₃₀ (Ī₁ − 3)³ + c₀₁ (Ī₂ − 3) + κ/2 (J − 1)²,
                        Ī₁ = a(J) I₁, Ī₂ = b(J) I₂, a = J^(−2/3), b = J^(−4/3)

The Rivlin density is Neo-Hookean with c₁₀ = μ/2 alone, Mooney-Rivlin with c₀₁, Yeoh with c₂₀ and c₃₀, in
the form finite-element programs use for nearly incompressible rubber (there κ = 2 / D₁).

All are finite and have two continuous derivatives for flat and inverted elements: a and b go over into
their Taylor polynomials of second degree below J = 0.2, so their energy still falls on the way back to J > 0.

Sources: Müller and Gross, Interactive Virtual Materials, 2004 (corotational); Smith, de Goes and Kim, Stable
Neo-Hookean Flesh Simulation, ACM Transactions on Graphics 37(2), 2018, equation (14) with the Lamé
parameters of its section 3.4; Rivlin and Saunders, Philosophical Transactions A 243, 1951; Yeoh,
Rubber Chemistry and Technology 66, 754, 1993.
"""

from __future__ import annotations

import numpy as np

from tauten.model.numerics import Array, kernel

COROTATIONAL, STABLE_NEO_HOOKEAN, RIVLIN = 0, 1, 2
N_CONSTANTS = 5  # a law's row of constants: (λ, μ) or (c10, c20, c30, c01, κ), padded with zeros
CONTINUED = 0.2  # J below which powers of J go over into their Taylor polynomials


@kernel
def density(kind: int, c: Array, I: Array, d: Array) -> None:  # noqa: E741
    """The density and its derivatives that are not zero for every law.

    Args:
        kind: COROTATIONAL, STABLE_NEO_HOOKEAN or RIVLIN.
        c: (5,) constants: (λ, μ) or (c10, c20, c30, c01, κ) [Pa].
        I: (4,) invariants S, I₁, I₂, J.
        d: (10,) output: ψ, its derivatives by S, I₁, I₂, J and by SS, I₁I₁, I₁J, I₂J, JJ [Pa].
    """
    S, I1, I2, J = I[0], I[1], I[2], I[3]
    d[:] = 0.0
    if kind == COROTATIONAL:
        lam, mu = c[0], c[1]
        d[0] = mu * (I1 - 2.0 * S + 3.0) + 0.5 * lam * (S - 3.0) ** 2
        d[1] = lam * (S - 3.0) - 2.0 * mu
        d[2] = mu
        d[5] = lam
    elif kind == STABLE_NEO_HOOKEAN:
        mu = 4.0 / 3.0 * c[1]
        lam = c[0] + 5.0 / 6.0 * c[1]
        # λ̂/2 (J − α)² = λ̂/2 (J − 1)² − 3/4 μ̂ (J − 1) + const, which needs no division by λ̂
        d[0] = 0.5 * mu * (I1 - 3.0 - np.log((I1 + 1.0) / 4.0))
        d[0] += 0.5 * lam * (J - 1.0) ** 2 - 0.75 * mu * (J - 1.0)
        d[2] = 0.5 * mu * (1.0 - 1.0 / (I1 + 1.0))
        d[4] = lam * (J - 1.0) - 0.75 * mu
        d[6] = 0.5 * mu / (I1 + 1.0) ** 2
        d[9] = lam
    else:
        d[4], d[9] = c[4] * (J - 1.0), c[4]
        d[0] = 0.5 * c[4] * (J - 1.0) ** 2
        if c[0] != 0.0 or c[1] != 0.0 or c[2] != 0.0:
            a, da, dda = power(J, -2.0 / 3.0)
            y = a * I1 - 3.0
            f1 = c[0] + y * (2.0 * c[1] + 3.0 * y * c[2])
            f2 = 2.0 * c[1] + 6.0 * y * c[2]
            d[0] += y * (c[0] + y * (c[1] + y * c[2]))
            d[2] = f1 * a
            d[4] += f1 * da * I1
            d[6] = f2 * a * a
            d[7] = f2 * a * da * I1 + f1 * da
            d[9] += f2 * (da * I1) ** 2 + f1 * dda * I1
        if c[3] != 0.0:
            b, db, ddb = power(J, -4.0 / 3.0)
            d[0] += c[3] * (b * I2 - 3.0)
            d[3] = c[3] * b
            d[4] += c[3] * db * I2
            d[8] = c[3] * db
            d[9] += c[3] * ddb * I2


@kernel
def power(J: float, p: float) -> tuple[float, float, float]:
    """J^p with its first two derivatives, a parabola below J = CONTINUED."""
    x = max(J, CONTINUED)
    value = x**p
    first = p * value / x
    second = (p - 1.0) * first / x
    s = J - x  # zero or negative
    return value + s * (first + 0.5 * s * second), first + s * second, second
