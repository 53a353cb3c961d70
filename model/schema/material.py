"""Materials of a robot file."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import ConfigDict, Field, model_validator

from tauten.model.materials import (
    ELASTIC,
    Law,
    Viscosity,
    corotational,
    find_silicone,
    mooney_rivlin,
    neo_hookean,
    stable_neo_hookean,
    yeoh,
)
from tauten.model.schema.region import Selection
from tauten.model.schema.section import Section, in_range

LawName = Literal["corotational", "stable-neo-hookean", "neo-hookean", "mooney-rivlin", "yeoh"]


WATER = 1000.0  # kg/m³; any density serves where the total mass is given


class MaterialSettings(Section):
    """Isotropic material."""

    young_modulus: Annotated[float, in_range(1e2, 1e12, "Pa")] = Field(
        description="Young's modulus [Pa]; hyperelastic constants give it where it is missing."
    )
    poisson_ratio: Annotated[float, Field(ge=0.0, lt=0.5)] = Field(
        description="Poisson's ratio, unitless."
    )
    density: Annotated[float, in_range(1.0, 3e4, "kg/m³")] = Field(description="Density [kg/m³].")


def _required(schema: dict[str, Any]) -> None:
    """Which fields a material needs, in its JSON Schema: a silicone or a law gives some of them."""
    schema.pop("required", None)
    stiffness = (["young_modulus", "poisson_ratio"], ["c10", "poisson_ratio"])
    sets = [["silicone"], *([*one, mass] for one in stiffness for mass in _MASS)]
    schema["anyOf"] = [{"required": names} for names in sets]


_MASS = ("density", "total_mass")


class ViscositySettings(Section):
    """Viscosity of a material besides its elastic law, which is what remains after a long time."""

    shear_viscosity: float = Field(
        default=0.0,
        ge=0.0,
        le=1e9,
        description="Kelvin-Voigt viscosity of shear μ_v [Pa s], default 0.",
    )
    volume_viscosity: float = Field(
        default=0.0,
        ge=0.0,
        le=1e9,
        description="Kelvin-Voigt viscosity of changes of volume λ_v [Pa s], default 0.",
    )
    shares: tuple[Annotated[float, Field(gt=0.0, le=1e3)], ...] = Field(
        default=(),
        max_length=8,
        description="Stiffness of each Maxwell branch relative to the elastic law's [1], default none.",
    )
    times: tuple[Annotated[float, Field(ge=1e-6, le=1e6)], ...] = Field(
        default=(), description="Relaxation time of each Maxwell branch [s], as many as shares."
    )

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if len(self.shares) != len(self.times):
            raise ValueError(
                f"{len(self.shares)} shares and {len(self.times)} times, a Maxwell branch has one of each"
            )
        if not self.shares and self.shear_viscosity == self.volume_viscosity == 0.0:
            raise ValueError("needs shear_viscosity, volume_viscosity, or shares and times")
        return self


class SolidMaterialSettings(MaterialSettings):
    """Material of a body made of tetrahedra.

    The constants of a law give `young_modulus`; a `young_modulus` beside them scales the law to it.
    """

    model_config = ConfigDict(json_schema_extra=_required)

    law: LawName = Field(
        default="corotational", description="Law of elasticity, by default corotational."
    )
    silicone: str | None = Field(
        default=None,
        description="Name of a measured silicone (a Yeoh law), which gives the values that the table does "
        "not set; by default none.",
    )
    c10: float | None = Field(
        default=None, description="First constant of Mooney-Rivlin and Yeoh [Pa]; by default none."
    )
    c01: float | None = Field(
        default=None, description="Second constant of Mooney-Rivlin [Pa]; by default 0."
    )
    c20: float | None = Field(
        default=None, description="Second constant of Yeoh [Pa]; by default 0."
    )
    c30: float | None = Field(
        default=None, description="Third constant of Yeoh [Pa]; by default 0."
    )

    viscosity: ViscositySettings | None = Field(
        default=None,
        description="Viscosity besides the elastic law; without it the material is elastic.",
    )

    total_mass: Annotated[float, in_range(1e-9, 1e6, "kg")] | None = Field(
        default=None,
        description="Mass of the whole body [kg]; densities then only say how it is shared out, and may be "
        "left out. By default the densities give it.",
    )
    mass: Literal["volume", "nodes"] = Field(
        default="volume",
        description="How the mass is shared out: by the volume around each node (volume, default), or the "
        "same on every node of the body, fixed ones too (nodes), which needs total_mass; SOFA's UniformMass.",
    )

    @model_validator(mode="before")
    @classmethod
    def _filled(cls, raw: Any) -> Any:
        if not isinstance(raw, dict):
            return raw
        filled = dict(raw)
        if isinstance(raw.get("silicone"), str):
            item = find_silicone(raw["silicone"])
            if filled.setdefault("law", "yeoh") != "yeoh":
                raise ValueError(f"law is {raw['law']!r}, silicones have the law 'yeoh'")
            for name in ("c10", "c20", "poisson_ratio", "density"):
                filled.setdefault(name, getattr(item, name))
        if filled.get("total_mass") is not None:
            filled.setdefault("density", WATER)
        c10, c01, nu = (filled.get(name) for name in ("c10", "c01", "poisson_ratio"))
        if isinstance(c10, int | float) and isinstance(nu, int | float):
            shear = 2.0 * (c10 + (c01 if isinstance(c01, int | float) else 0.0))
            filled.setdefault("young_modulus", 2.0 * shear * (1.0 + nu))
        return filled

    @model_validator(mode="after")
    def _makes_a_law(self) -> Self:
        self.elastic_law()
        if self.mass == "nodes" and self.total_mass is None and not hasattr(self, "region"):
            raise ValueError('mass = "nodes" shares out total_mass, which is missing')
        return self

    def viscous(self) -> Viscosity:
        """The viscosity these settings describe."""
        item = self.viscosity
        if item is None:
            return ELASTIC
        return Viscosity(item.shear_viscosity, item.volume_viscosity, item.shares, item.times)

    def elastic_law(self) -> Law:
        """The law these settings describe.

        Raises:
            ValueError: constants that are missing, that belong to another law, or that make no material.
        """
        nu, law = self.poisson_ratio, self.law
        allowed = {"mooney-rivlin": ("c10", "c01"), "yeoh": ("c10", "c20", "c30")}.get(law, ())
        given = [name for name in ("c10", "c01", "c20", "c30") if getattr(self, name) is not None]
        strange = [name for name in given if name not in allowed]
        if strange:
            takes = ", ".join(allowed) or "young_modulus and poisson_ratio alone"
            raise ValueError(f"{strange[0]} is no constant of the law {law!r}, which takes {takes}")
        if allowed and self.c10 is None:
            raise ValueError(f"the law {law!r} needs c10")
        if law == "mooney-rivlin":
            made = mooney_rivlin(self.c10 or 0.0, self.c01 or 0.0, nu)
        elif law == "yeoh":
            made = yeoh(self.c10 or 0.0, self.c20 or 0.0, self.c30 or 0.0, nu)
        elif law == "neo-hookean":
            made = neo_hookean(self.young_modulus, nu)
        elif law == "stable-neo-hookean":
            made = stable_neo_hookean(self.young_modulus, nu)
        else:
            made = corotational(self.young_modulus, nu)
        return made.scaled_to(self.young_modulus)


class RegionMaterialSettings(SolidMaterialSettings):
    """Another material for the elements of a region; a later region replaces it."""

    region: Annotated[
        Selection,
        Field(
            description="Elements that have it: a region or the name of one. Boxes and other shapes select "
            "elements by their centre."
        ),
    ]

    @model_validator(mode="after")
    def _part_only(self) -> Self:
        if self.total_mass is not None or self.mass == "nodes":
            field = "total_mass" if self.total_mass is not None else "mass"
            raise ValueError(f"{field} belongs to the body's material, a part has a density")
        return self


def with_densities(raw: Any, shared: Any = None) -> Any:
    """A table with `material` and `materials`, not validated, with the densities that may be left out.

    Where `material` has a total mass, a part without density has that of `material`.
    """
    if not isinstance(raw, dict):
        return raw
    whole, parts = raw.get("material", shared), raw.get("materials")
    if isinstance(whole, SolidMaterialSettings):
        whole = whole.model_dump()
    if not isinstance(whole, dict) or whole.get("total_mass") is None:
        return raw
    if not isinstance(parts, list | tuple):
        return raw
    density = whole.get("density", WATER)
    filled = [
        {"density": density, **part} if isinstance(part, dict) and "silicone" not in part else part
        for part in parts
    ]
    return {**raw, "materials": filled}
