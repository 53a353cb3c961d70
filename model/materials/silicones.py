"""Named silicones: Yeoh constants fitted to published tensile tests.

Contains information from the Soft Robotics Materials Database (tensile tests after ASTM D412,
github.com/LucMarechal/Soft-Robotics-Materials-Database), made available under the Open Database License 1.0.
Reference: Marechal, Balland, Lindenroth, Petrou, Kontovounisios and Bello, Towards a Common Framework and
Database of Materials for Soft Robotics, Soft Robotics, 2020, doi 10.1089/soro.2019.0115.

The constants are the non-negative least-squares fit to engineering strains up to 1, made by

    python -m benchmarks.elements.fit_silicones FOLDER_OF_THE_TENSILE_TESTS

The tests measured strain between the grips and pulled at 450 mm/min to failure; their stress at a strain of 1
is 43 to 74 % of the 100 % modulus on the manufacturer's data sheets (10, 12, 22 and 86 psi). Where forces
matter, measure your own casting and give `c10`, `c20` and `c30`.
"""

from __future__ import annotations

from dataclasses import dataclass

from tauten.model.materials.law import MaterialError

POISSON_RATIO = 0.49  # silicones are nearly incompressible; more only makes the equations stiffer


@dataclass(frozen=True, slots=True)
class Silicone:
    """A casting silicone.

    Attributes:
        name: as robot files call it.
        test: its file in the Soft Robotics Materials Database.
        c10: first constant of Yeoh [Pa].
        c20: second constant of Yeoh [Pa]; the third is zero in all fits.
        density: of the manufacturer's data sheet (Smooth-On) [kg/m³].
        poisson_ratio: ν.
    """

    name: str
    test: str
    c10: float
    c20: float
    density: float
    poisson_ratio: float = POISSON_RATIO


SILICONES = (
    Silicone("ecoflex-00-30", "Ecoflex 00-30", 7504.0, 238.0, 1070.0),
    Silicone("ecoflex-00-50", "Ecoflex 00-50", 10269.0, 391.0, 1070.0),
    Silicone("dragon-skin-10", "Dragon Skin 10 MEDIUM", 21850.0, 2753.0, 1070.0),
    Silicone("dragon-skin-30", "Dragon Skin 30", 90413.0, 9082.0, 1080.0),
)


def find_silicone(name: str) -> Silicone:
    """The silicone of this name.

    Raises:
        MaterialError: there is none.
    """
    for item in SILICONES:
        if item.name == name:
            return item
    known = ", ".join(item.name for item in SILICONES)
    raise MaterialError(f"silicone is {name!r}, known are {known}")
