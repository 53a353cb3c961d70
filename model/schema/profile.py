"""Cross-sections of beams."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from tauten.model.schema.section import Name, Section, Thickness, in_range

THINNEST_WALL = 2e-6  # m, difference of diameters
Stiffness = Annotated[float, in_range(1e-12, 1e15, "")]


class TubeSettings(Section):
    """A round cross-section: outer and inner diameter [m]."""

    kind: Literal["tube"] = Field(description="A round cross-section.")
    name: Name = Field(description="Name of the cross-section, used once.")
    outer: Thickness = Field(description="Outer diameter [m].")
    inner: Annotated[float, Field(ge=0.0)] = Field(
        default=0.0, description="Inner diameter [m], by default 0: solid."
    )

    @model_validator(mode="after")
    def _hollow(self) -> TubeSettings:
        if self.inner >= self.outer:
            raise ValueError(f"inner {self.inner} must be less than outer {self.outer}")
        if self.outer - self.inner < THINNEST_WALL:
            raise ValueError(
                f"inner {self.inner} and outer {self.outer} differ by less than {THINNEST_WALL:g} m"
            )
        return self


class BarSettings(Section):
    """A rectangular cross-section: width along axis 2, height along axis 3, which is near `up` [m]."""

    kind: Literal["bar"] = Field(description="A rectangular cross-section.")
    name: Name = Field(description="Name of the cross-section, used once.")
    width: Thickness = Field(description="Size along axis 2 [m].")
    height: Thickness = Field(description="Size along axis 3, which is near `up` of the beam [m].")


class SectionSettings(Section):
    """A cross-section by its stiffnesses and its mass, as measured or from a table.

    Axis 1 lies along the beam, axis 3 near `up` of the beam, axis 2 across both.
    """

    kind: Literal["section"] = Field(description="A cross-section by its stiffnesses.")
    name: Name = Field(description="Name of the cross-section, used once.")
    axial: Stiffness = Field(description="Stiffness E A against stretching [N].")
    bending: tuple[Stiffness, Stiffness] = Field(
        description="Stiffnesses E I against bending about axes 2 and 3 [N m²]."
    )
    torsion: Stiffness = Field(description="Stiffness G J against twisting [N m²].")
    shear: tuple[Stiffness, Stiffness] | None = Field(
        default=None,
        description="Stiffnesses κ G A against shear along axes 2 and 3 [N]; by default it does not shear.",
    )
    mass: Annotated[float, in_range(1e-9, 1e6, "kg/m")] = Field(
        description="Mass of a length of the beam [kg/m]."
    )
    diameter: Thickness = Field(description="Diameter with which it is drawn [m].")

    def scaled(self, factor: float) -> SectionSettings:
        """The same cross-section `factor` times as stiff."""
        contents = self.model_dump()
        for name in ("axial", "torsion"):
            contents[name] *= factor
        for name in ("bending", "shear"):
            pair = contents[name]
            contents[name] = None if pair is None else [factor * value for value in pair]
        return SectionSettings.model_validate(contents)


AnyProfile = Annotated[TubeSettings | BarSettings | SectionSettings, Field(discriminator="kind")]
