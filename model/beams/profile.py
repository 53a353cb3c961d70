"""Materials and cross-sections of beams, and the stiffnesses of a beam's natural modes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.numerics import Array
from tauten.model.schema import SectionSettings

OUTLINE_CORNERS = 8  # of a round cross-section, as it is drawn


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
    def shear_modulus(self) -> float:
        """G [Pa]."""
        return self.young_modulus / (2.0 * (1.0 + self.poisson_ratio))


@dataclass(frozen=True, slots=True)
class Profile:
    """A cross-section; axis 2 and 3 are its principal axes.

    Attributes:
        area: A [m²].
        shear_area: κ A for shear along axes 2 and 3 [m²]; +inf for beams without shear.
        torsion: J [m⁴].
        bending: second moments I for bending about axes 2 and 3 [m⁴].
        outline: (c, 2) corners of the cross-section along axes 2 and 3, for drawing [m].
        mass: of a length of the beam [kg/m]; None: density times area.
    """

    area: float
    shear_area: tuple[float, float]
    torsion: float
    bending: tuple[float, float]
    outline: Array
    mass: float | None = None


def tube(outer: float, inner: float = 0.0) -> Profile:
    """A round tube of two diameters [m], or a rod when `inner` is zero."""
    area = np.pi / 4.0 * (outer**2 - inner**2)
    moment = np.pi / 64.0 * (outer**4 - inner**4)
    # Cowper 1966 for ν → 0.4, between a rod (0.9) and a thin tube (0.53)
    kappa = 0.9 - 0.37 * min(1.0, 1.5 * inner / outer)
    shear = (kappa * area, kappa * area)
    return Profile(area, shear, 2.0 * moment, (moment, moment), round_outline(outer))


def round_outline(diameter: float) -> Array:
    """Corners (c, 2) of a round cross-section [m]."""
    angle = 2.0 * np.pi * np.arange(OUTLINE_CORNERS) / OUTLINE_CORNERS
    return np.asarray(0.5 * diameter * np.stack([np.cos(angle), np.sin(angle)], axis=1))


def section(settings: SectionSettings, material: Material) -> Profile:
    """The cross-section that has given stiffnesses with a material."""
    E, G = material.young_modulus, material.shear_modulus
    shear = (np.inf, np.inf) if settings.shear is None else settings.shear
    return Profile(
        area=settings.axial / E,
        shear_area=(shear[0] / G, shear[1] / G),
        torsion=settings.torsion / G,
        bending=(settings.bending[0] / E, settings.bending[1] / E),
        outline=round_outline(settings.diameter),
        mass=settings.mass,
    )


def bar(width: float, height: float) -> Profile:
    """A rectangular bar, `width` along axis 2 and `height` along axis 3 [m]."""
    area = width * height
    long, short = max(width, height), min(width, height)
    # Roark: within 4 % of the series solution for torsion of rectangles
    torsion = long * short**3 * (1.0 / 3.0 - 0.21 * short / long * (1.0 - (short / long) ** 4 / 12))
    bending = (width * height**3 / 12.0, height * width**3 / 12.0)
    y, z = 0.5 * width, 0.5 * height
    outline = np.array([[-y, -z], [y, -z], [y, z], [-y, z]])
    return Profile(area, (5 / 6 * area, 5 / 6 * area), float(torsion), bending, outline)


def natural_stiffness(profile: Profile, material: Material, length: float) -> Array:
    """Stiffnesses (6,) of the natural modes (B1): of u along axes 1, 2, 3 [N/m], of φ about these [N m].

    The antisymmetric modes bend and shear: with w the offset of the ends, both kept parallel to the
    chord's frame, 1/k = L³ / (12 E I) + L / (κ G A).

    Args:
        profile: cross-section.
        material: of the beam.
        length: L [m].
    """
    E, G = material.young_modulus, material.shear_modulus
    (I2, I3), (A2, A3) = profile.bending, profile.shear_area
    return np.array(
        [
            E * profile.area / length,
            1.0 / (length**3 / (12.0 * E * I3) + length / (G * A2)),
            1.0 / (length**3 / (12.0 * E * I2) + length / (G * A3)),
            G * profile.torsion / length,
            E * I2 / length,
            E * I3 / length,
        ]
    )
