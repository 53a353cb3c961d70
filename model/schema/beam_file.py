"""The robot file of a robot made of beams, and the structure file beside it."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field, model_validator

from tauten.model.schema.material import MaterialSettings
from tauten.model.schema.profile import AnyProfile
from tauten.model.schema.region import Selection
from tauten.model.schema.robot_file import RobotSettings, check_unique
from tauten.model.schema.section import Direction, Name, Point, Section, Thickness

AS_BODIES = "for that write the beams as bodies, with bodies.beam instead of a structure file"
Index = Annotated[int, Field(ge=0)]


class StructureSettings(Section):
    """The file with nodes, beams, vertebrae and surfaces."""

    file: str = Field(description="Structure file, JSON, relative to the robot file.")


class BeamConfig(RobotSettings):
    """The file of a robot made of beams."""

    material: MaterialSettings = Field(description="Material of the beams.")
    fixed: Annotated[tuple[Selection, ...], Field(min_length=1)] = Field(
        description="Regions, or their names, whose nodes do not move."
    )
    beams: StructureSettings = Field(description="The structure file.")
    profiles: Annotated[
        list[AnyProfile],
        Field(min_length=1),
    ] = Field(description="Cross-sections that the structure file names, one table each.")

    @model_validator(mode="before")
    @classmethod
    def _no_bodies(cls, raw: Any) -> Any:
        for table in ("mesh", "bodies", "rigid", "attachments"):
            if isinstance(raw, dict) and table in raw:
                raise ValueError(f"{table}: not beside a structure file; {AS_BODIES}")
        return raw

    @model_validator(mode="after")
    def _cables_and_forces(self) -> BeamConfig:
        if self.chambers:
            raise ValueError(
                "chambers: beams enclose no cavity; a chamber is part of a body with a mesh"
            )
        if self.drives:
            raise ValueError(f"drives: they move regions of bodies; {AS_BODIES}")
        for index, item in enumerate(self.couplings):
            if item.kind == "drum":
                raise ValueError(
                    f"couplings.{index}.kind: a drum is a coordinate beside those of nodes; {AS_BODIES}"
                )
        return self

    @model_validator(mode="after")
    def _profiles(self) -> BeamConfig:
        check_unique("profiles", [profile.name for profile in self.profiles])
        return self


class BeamElement(Section):
    """A beam between two nodes; `up` is near axis 3 of its cross-section."""

    ends: tuple[Index, Index]
    profile: Name
    up: Direction


class Vertebra(Section):
    """A rigid round disc on a node, which cables pass through and effectors are attached to [m].

    Its mass, with the density of the robot's material, is added to the node.
    """

    name: Name
    node: Index
    radius: Thickness
    thickness: Thickness
    axis: Direction = (0.0, 0.0, 1.0)


class AttachedSurface(Section):
    """Triangles between points that are each attached to a node; counter-clockwise seen from outside [m]."""

    name: Name
    nodes: list[Index]
    points: list[Point]
    triangles: Annotated[list[tuple[Index, Index, Index]], Field(min_length=1)]

    @model_validator(mode="after")
    def _consistent(self) -> AttachedSurface:
        if len(self.nodes) != len(self.points):
            raise ValueError(
                f"surface {self.name!r} has {len(self.points)} points and {len(self.nodes)} nodes"
            )
        last = max(max(corners) for corners in self.triangles)
        if last >= len(self.points):
            raise ValueError(
                f"surface {self.name!r}: a triangle names point {last}, "
                f"there are 0 to {len(self.points) - 1}"
            )
        return self


class Structure(Section):
    """The structure file: all in rest position, in the robot's frame [m].

    `refine` halves the beams, for a comparison of errors.
    """

    nodes: Annotated[list[Point], Field(min_length=2)]
    beams: Annotated[list[BeamElement], Field(min_length=1)]
    vertebrae: Annotated[list[Vertebra], Field(min_length=1)]
    surfaces: tuple[AttachedSurface, ...] = ()

    @model_validator(mode="after")
    def _names(self) -> Structure:
        check_unique("vertebrae", [vertebra.name for vertebra in self.vertebrae])
        check_unique("surfaces", [surface.name for surface in self.surfaces])
        last = len(self.nodes) - 1
        for index, beam in enumerate(self.beams):
            if max(beam.ends) > last:
                raise ValueError(f"beams.{index}: ends {beam.ends}, there are nodes 0 to {last}")
        for vertebra in self.vertebrae:
            if vertebra.node > last:
                raise ValueError(
                    f"vertebra {vertebra.name!r}: node {vertebra.node}, there are 0 to {last}"
                )
        for surface in self.surfaces:
            if surface.nodes and max(surface.nodes) > last:
                raise ValueError(
                    f"surface {surface.name!r}: node {max(surface.nodes)}, there are 0 to {last}"
                )
        return self

    def refine(self) -> Structure:
        """The same structure with a node in the middle of every beam."""
        nodes, beams = list(self.nodes), []
        for beam in self.beams:
            a, b = beam.ends
            x, y, z = (0.5 * (p + q) for p, q in zip(self.nodes[a], self.nodes[b], strict=True))
            middle = len(nodes)
            nodes.append((x, y, z))
            beams += [beam.model_copy(update={"ends": ends}) for ends in ((a, middle), (middle, b))]
        return self.model_copy(update={"nodes": nodes, "beams": beams})
