"""Viscosity of a material beside its elastic law: Kelvin-Voigt, and Maxwell branches (a Prony series).

Both act on the Green strain E = ½ (FᵀF − I) with second Piola-Kirchhoff stresses, so that rigid motion
causes no stress and the stress turns with the body:

    S = λ_v tr(Ė) I + 2 μ_v Ė + Σ Q_i,   Q̇_i + Q_i / τ_i = g_i (λ tr(Ė) I + 2 μ Ė)            (V1)

with the shear and volume viscosities μ_v, λ_v, and branches of relative stiffness g_i and relaxation time
τ_i. The elastic law is what remains after a long time. (Simo and Hughes, Computational Inelasticity, 1998,
chapter 10: finite linear viscoelasticity.)
"""

from __future__ import annotations

from dataclasses import dataclass, replace


@dataclass(frozen=True, slots=True)
class Viscosity:
    """Constants of (V1).

    Attributes:
        shear: μ_v [Pa s].
        volume: λ_v [Pa s].
        shares: (b,) stiffness of each branch relative to the elastic law's for small strain.
        times: (b,) relaxation times of the branches [s].
    """

    shear: float = 0.0
    volume: float = 0.0
    shares: tuple[float, ...] = ()
    times: tuple[float, ...] = ()

    def parts(self) -> tuple[Viscosity, Viscosity]:
        """What belongs to the shear part of a law and what to its volume part, see `Law.parts`."""
        return replace(self, volume=0.0), replace(self, shear=0.0)


ELASTIC = Viscosity()
