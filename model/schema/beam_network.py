"""The file of a network of beams, which a body of a robot file names in place of a line of points."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from tauten.model.schema.section import Direction, Name, Point, Section, Thickness, check_unique

Index = Annotated[int, Field(ge=0)]


class BeamElement(Section):
    """A beam between two nodes; `up` is near axis 3 of its cross-section.

    Without `up` it is the axis of the robot's frame that lies across the beam most.
    """

    ends: tuple[Index, Index]
    profile: Name
    up: Direction | None = None


class Disc(Section):
    """A rigid round disc on a node [m], which points near it are attached to.

    Its mass, with the density of the body's material, is added to the node.
    """

    name: Name
    node: Index
    radius: Thickness
    thickness: Thickness
    axis: Direction = (0.0, 0.0, 1.0)


class AttachedSurface(Section):
    """Triangles between points that are each attached to a node; counter-clockwise seen from outside [m].

    Regions of the kind `group` select it by its name.
    """

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


class BeamNetwork(Section):
    """Beams that join nodes: all in rest position, in the body's coordinates [m].

    `refine` halves the beams, for a comparison of errors.
    """

    nodes: Annotated[list[Point], Field(min_length=2)]
    beams: Annotated[list[BeamElement], Field(min_length=1)]
    discs: tuple[Disc, ...] = ()
    surfaces: tuple[AttachedSurface, ...] = ()

    @model_validator(mode="after")
    def _names(self) -> BeamNetwork:
        check_unique("discs", [disc.name for disc in self.discs])
        check_unique("surfaces", [surface.name for surface in self.surfaces])
        last = len(self.nodes) - 1
        for index, beam in enumerate(self.beams):
            if max(beam.ends) > last:
                raise ValueError(f"beams.{index}: ends {beam.ends}, there are nodes 0 to {last}")
        for disc in self.discs:
            if disc.node > last:
                raise ValueError(f"disc {disc.name!r}: node {disc.node}, there are 0 to {last}")
        for surface in self.surfaces:
            if surface.nodes and max(surface.nodes) > last:
                raise ValueError(
                    f"surface {surface.name!r}: node {max(surface.nodes)}, there are 0 to {last}"
                )
        return self

    def refine(self) -> BeamNetwork:
        """The same network with a node in the middle of every beam."""
        nodes, beams = list(self.nodes), []
        for beam in self.beams:
            a, b = beam.ends
            x, y, z = (0.5 * (p + q) for p, q in zip(self.nodes[a], self.nodes[b], strict=True))
            middle = len(nodes)
            nodes.append((x, y, z))
            beams += [beam.model_copy(update={"ends": ends}) for ends in ((a, middle), (middle, b))]
        return self.model_copy(update={"nodes": nodes, "beams": beams})
