"""Elastic laws: which density, with which constants."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.materials.densities import COROTATIONAL, N_CONSTANTS, RIVLIN, STABLE_NEO_HOOKEAN
from tauten.model.numerics import Array, Ints


class MaterialError(ValueError):
    """Constants that no material has; the text names them, the value found and the values allowed."""


@dataclass(frozen=True, slots=True)
class Law:
    """An isotropic hyperelastic law, made by one of the functions of this module.

    Attributes:
        name: as robot files call it.
        kind: the density, see `densities`.
        constants: (5,) of the density [Pa].
        lame: Lamé parameters (λ, μ) for small strain [Pa].
    """

    name: str
    kind: int
    constants: tuple[float, ...]
    lame: tuple[float, float]

    @property
    def young_modulus(self) -> float:
        """E for small strain [Pa]."""
        lam, mu = self.lame
        return mu * (3.0 * lam + 2.0 * mu) / (lam + mu)

    def scaled_to(self, young_modulus: float) -> Law:
        """The same law with another Young's modulus for small strain [Pa]; every stress scales with it."""
        factor = young_modulus / self.young_modulus
        lam, mu = self.lame
        constants = tuple(factor * constant for constant in self.constants)
        return Law(self.name, self.kind, constants, (factor * lam, factor * mu))

    def parts(self) -> tuple[Law, Law]:
        """The law with λ = 0 and what λ adds, a function of the volume (or of tr S) alone.

        Their energies add up; elements that average the two over different domains need them apart.
        """
        lam, mu = self.lame
        shear, volume = list(self.constants), [0.0] * N_CONSTANTS
        place = 4 if self.kind == RIVLIN else 0
        shear[place], volume[place] = 2.0 / 3.0 * mu if self.kind == RIVLIN else 0.0, lam
        return (
            Law(f"{self.name}, shear", self.kind, tuple(shear), (0.0, mu)),
            Law(f"{self.name}, volume", self.kind, tuple(volume), (lam, 0.0)),
        )


def law_arrays(laws: list[Law]) -> tuple[Ints, Array]:
    """Kinds (m,) of laws, and their constants, λ and μ (m, 7), as the kernels read them."""
    kinds = np.array([law.kind for law in laws], dtype=np.int64)
    numbers = np.array([(*law.constants, *law.lame) for law in laws])
    return kinds, numbers.reshape(-1, N_CONSTANTS + 2)


def lame_parameters(young_modulus: float, poisson_ratio: float) -> tuple[float, float]:
    """Lamé's λ and the shear modulus μ of E and ν [Pa].

    Raises:
        MaterialError: E is not positive, or ν is not between 0 and 1/2.
    """
    E, nu = young_modulus, poisson_ratio
    if not (0.0 < E < np.inf):
        raise MaterialError(f"young_modulus is {E:g} Pa, it must be positive")
    if not 0.0 <= nu < 0.5:
        raise MaterialError(
            f"poisson_ratio is {nu:g}, allowed is 0 up to less than 0.5: no element here is exactly "
            "incompressible, use 0.49 to 0.499 for rubber"
        )
    return E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), E / (2.0 * (1.0 + nu))


def corotational(young_modulus: float, poisson_ratio: float) -> Law:
    """Linear elasticity in the frame of the polar rotation: E [Pa] and ν."""
    lame = lame_parameters(young_modulus, poisson_ratio)
    return Law("corotational", COROTATIONAL, (*lame, 0.0, 0.0, 0.0), lame)


def stable_neo_hookean(young_modulus: float, poisson_ratio: float) -> Law:
    """Stable Neo-Hookean (Smith, de Goes and Kim 2018): E [Pa] and ν for small strain."""
    lame = lame_parameters(young_modulus, poisson_ratio)
    return Law("stable-neo-hookean", STABLE_NEO_HOOKEAN, (*lame, 0.0, 0.0, 0.0), lame)


def neo_hookean(young_modulus: float, poisson_ratio: float) -> Law:
    """Neo-Hookean, c₁₀ = μ/2 and κ = λ + 2/3 μ: E [Pa] and ν for small strain."""
    lam, mu = lame_parameters(young_modulus, poisson_ratio)
    constants = (0.5 * mu, 0.0, 0.0, 0.0, lam + 2.0 / 3.0 * mu)
    return Law("neo-hookean", RIVLIN, constants, (lam, mu))


def mooney_rivlin(c10: float, c01: float, poisson_ratio: float) -> Law:
    """Mooney-Rivlin from c₁₀, c₀₁ [Pa] and ν for small strain.

    Args:
        c10: c₁₀ [Pa].
        c01: c₀₁ [Pa].
        poisson_ratio: ν for small strain.

    Raises:
        MaterialError: c₁₀ is not positive, c₀₁ is negative, or ν is not between 0 and 1/2.
    """
    if not (0.0 < c10 < np.inf and 0.0 <= c01 < np.inf):
        raise MaterialError(
            f"c10 is {c10:g} Pa and c01 is {c01:g} Pa, c10 must be positive and c01 not negative, "
            "else the energy falls in some large deformation"
        )
    lam, mu = of_shear(2.0 * (c10 + c01), poisson_ratio)
    constants = (c10, 0.0, 0.0, c01, lam + 2.0 / 3.0 * mu)
    return Law("mooney-rivlin", RIVLIN, constants, (lam, mu))


def yeoh(c10: float, c20: float, c30: float, poisson_ratio: float) -> Law:
    """Yeoh from c₁₀, c₂₀, c₃₀ [Pa] and ν for small strain.

    Args:
        c10: c₁₀ [Pa].
        c20: c₂₀ [Pa].
        c30: c₃₀ [Pa].
        poisson_ratio: ν for small strain.

    Raises:
        MaterialError: the energy would fall at some Ī₁ ≥ 3, or ν is not between 0 and 1/2.
    """
    slopes = [c10]  # of c₁₀ y + c₂₀ y² + c₃₀ y³ at y = 0 and, if it is at y > 0, at its least
    if c30 > 0.0 and c20 < 0.0:
        slopes.append(c10 - c20 * c20 / (3.0 * c30))
    stiffens = c30 > 0.0 or (c30 == 0.0 and c20 >= 0.0)
    if not (np.isfinite([c10, c20, c30]).all() and min(slopes) > 0.0 and stiffens):
        raise MaterialError(
            f"c10 {c10:g}, c20 {c20:g}, c30 {c30:g} Pa: c10 + 2 c20 y + 3 c30 y² must be positive for every "
            "y = Ī₁ − 3 ≥ 0, else the material softens without limit"
        )
    lam, mu = of_shear(2.0 * c10, poisson_ratio)
    return Law("yeoh", RIVLIN, (c10, c20, c30, 0.0, lam + 2.0 / 3.0 * mu), (lam, mu))


def of_shear(mu: float, poisson_ratio: float) -> tuple[float, float]:
    """Lamé parameters of a shear modulus [Pa] and ν."""
    return lame_parameters(2.0 * mu * (1.0 + poisson_ratio), poisson_ratio)
