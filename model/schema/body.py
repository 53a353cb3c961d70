"""Bodies of a robot file: a mesh or a beam, where it stands, what it is made of and what holds it."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field, model_validator

from tauten.model.schema.material import RegionMaterialSettings, SolidMaterialSettings
from tauten.model.schema.region import Selection
from tauten.model.schema.section import Direction, Name, Point, Section, in_range

ElementName = Literal["linear", "quadratic", "smoothed"]
Angle = Annotated[float, in_range(-360.0, 360.0, "deg")]
UNIT_NORM = 1e-3  # by which the norm of a quaternion may differ from 1; it is then made exact


class MeshSettings(Section):
    """The body's mesh; `length_unit` applies to the mesh file only, the robot file is in SI units."""

    file: str = Field(description="Mesh of the body, in any format that meshio reads.")
    length_unit: Literal["m", "cm", "mm"] = Field(
        default="m", description="Unit of the mesh file, by default m."
    )
    element: ElementName = Field(
        default="linear",
        description="Element of the body: linear tetrahedra (default); quadratic ones, with midpoints "
        "added to a linear mesh; smoothed: linear ones with strain smoothed around edges and change of "
        "volume smoothed around nodes.",
    )


class RotationSettings(Section):
    """A rotation, as an axis with an angle, as a unit quaternion or as Euler angles."""

    axis: Direction | None = Field(default=None, description="Axis of the rotation.")
    angle_deg: Angle | None = Field(
        default=None, description="Angle about the axis, right-handed [deg]."
    )
    quaternion: tuple[float, float, float, float] | None = Field(
        default=None, description="Unit quaternion w, x, y, z, instead of axis and angle."
    )
    euler_deg: tuple[Angle, Angle, Angle] | None = Field(
        default=None,
        description="Angles about the fixed axes x, y and z of the robot's frame [deg], applied in this "
        "order, instead of axis and angle; `rotation` of SOFA's loaders.",
    )

    @model_validator(mode="after")
    def _is_rotation(self) -> RotationSettings:
        by_axis = self.axis is not None and self.angle_deg is not None
        partly = self.axis is not None or self.angle_deg is not None
        ways = [by_axis, self.quaternion is not None, self.euler_deg is not None]
        if sum(ways) != 1 or (partly and not by_axis):
            raise ValueError("a rotation has an axis and angle_deg, or a quaternion, or euler_deg")
        if self.quaternion is not None:
            norm = math.hypot(*self.quaternion)
            if abs(norm - 1.0) > UNIT_NORM:
                raise ValueError(
                    f"the quaternion has the norm {norm:.6g}, a rotation has the norm 1"
                )
        return self

    @property
    def unit_quaternion(self) -> tuple[float, float, float, float]:
        """The rotation as w, x, y, z of norm 1."""
        if self.quaternion is not None:
            norm = math.hypot(*self.quaternion)
            w, x, y, z = (part / norm for part in self.quaternion)
            return w, x, y, z
        if self.euler_deg is not None:
            halves = [0.5 * math.radians(angle) for angle in self.euler_deg]
            (cx, cy, cz), (sx, sy, sz) = map(math.cos, halves), map(math.sin, halves)
            return (
                cx * cy * cz + sx * sy * sz,
                sx * cy * cz - cx * sy * sz,
                cx * sy * cz + sx * cy * sz,
                cx * cy * sz - sx * sy * cz,
            )
        assert self.axis is not None and self.angle_deg is not None
        half = 0.5 * math.radians(self.angle_deg)
        x, y, z = (math.sin(half) * part / math.hypot(*self.axis) for part in self.axis)
        return math.cos(half), x, y, z


class BeamSettings(Section):
    """A rod, tube or wire along a line, or a network of beams from a file."""

    points: Annotated[list[Point], Field(min_length=2)] | None = Field(
        default=None,
        description="Points of its axis at rest, in order [m]; it is straight between two of them.",
    )
    elements: Annotated[int, Field(ge=1, le=1000)] = Field(
        default=8, description="Elements between two successive points, by default 8."
    )
    profile: Name | None = Field(
        default=None, description="Name of its cross-section in `profiles`, with points."
    )
    up: Direction | None = Field(
        default=None,
        description="Direction near axis 3 of its cross-section; by default the axis of the robot's frame "
        "that lies across it most. It matters where the cross-section is not round.",
    )
    file: str | None = Field(
        default=None,
        description="JSON file with nodes, the beams that join them, discs on nodes and surfaces between "
        "points of them, instead of points, beside the robot file.",
    )

    @model_validator(mode="after")
    def _one_form(self) -> BeamSettings:
        if (self.points is None) == (self.file is None):
            found = "neither" if self.points is None else "both"
            raise ValueError(f"a beam has points or a file, this one has {found}")
        if self.points is not None and self.profile is None:
            raise ValueError("profile: Field required")
        beside = self.model_fields_set & {"elements", "profile", "up"}
        if self.file is not None and beside:
            raise ValueError(f"{min(beside)}: the file says it of each beam, leave it out")
        return self


class BodySettings(Section):
    """A body of a robot, with a mesh of tetrahedra or made of beams.

    Its own coordinates are those of its mesh or of its beams, in metres and scaled.
    """

    name: Name = Field(description="Name of the body, used once.")
    mesh: MeshSettings | None = Field(
        default=None, description="Mesh of the body; several bodies may have the same file."
    )
    beam: BeamSettings | None = Field(
        default=None, description="The beam or the beams, instead of a mesh, that the body is."
    )
    scale: Annotated[float, in_range(1e-6, 1e6, "")] = Field(
        default=1.0,
        description="Factor of all coordinates of the mesh or of the beam's points, unitless, by default 1.",
    )
    rotation: RotationSettings | None = Field(
        default=None, description="Rotation about the mesh's origin; by default none."
    )
    position: Point = Field(
        default=(0.0, 0.0, 0.0),
        description="Where the mesh's origin stands in the robot's frame [m], by default its origin.",
    )
    rigid: bool = Field(
        default=False, description="Whether the body is rigid; by default it deforms."
    )
    free: bool = Field(
        default=False,
        description="Whether nothing needs to hold the body, which then moves by its inertia alone.",
    )
    material: SolidMaterialSettings | None = Field(
        default=None, description="Material of the body; by default the robot's `material`."
    )
    materials: tuple[RegionMaterialSettings, ...] = Field(
        default=(),
        description="Other materials in parts of the body, in its own coordinates; by default none.",
    )
    fixed: tuple[Selection, ...] = Field(
        default=(),
        description="Regions of the body, in its own coordinates, whose nodes do not move; by default none.",
    )

    @model_validator(mode="after")
    def _one_shape(self) -> BodySettings:
        if (self.mesh is None) == (self.beam is None):
            found = "neither" if self.mesh is None else "both"
            raise ValueError(f"a body has a mesh or a beam, this one has {found}")
        if self.beam is not None and (self.rigid or self.materials):
            field = "rigid" if self.rigid else "materials"
            raise ValueError(f"{field}: a beam deforms and has one material, leave it out")
        return self
