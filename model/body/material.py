"""Isotropic linear elasticity."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Material:
    """An isotropic elastic material.

    Attributes:
        young_modulus: E [Pa].
        poisson_ratio: ν, below one half.
        density: ρ [kg/m³].
    """

    young_modulus: float
    poisson_ratio: float
    density: float

    @property
    def lame(self) -> tuple[float, float]:
        """Lamé's first parameter λ and the shear modulus μ [Pa]."""
        E, nu = self.young_modulus, self.poisson_ratio
        return E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), E / (2.0 * (1.0 + nu))
