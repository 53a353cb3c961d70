"""Surfaces and contacts of a robot file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated

from pydantic import Field

from tauten.model.schema.region import Box, Facing, Intersection, Region
from tauten.model.schema.section import Direction, Distance, Name, Section


class SurfaceSettings(Section):
    """Boundary triangles whose centre lies in the box and whose normal points along `normal`."""

    name: Name = Field(description="Name of the surface, used once.")
    box: Box = Field(description="Box in which the centres of the triangles lie [m].")
    normal: Direction | None = Field(
        default=None,
        description="Direction near which the outward normals of the triangles are; by default any.",
    )
    max_angle_deg: Annotated[float, Field(gt=0.0, le=180.0)] = Field(
        default=45.0,
        description="Largest angle between `normal` and the normal of a triangle [deg], by default 45.",
    )

    def region(self) -> Region:
        """The same as a region."""
        if self.normal is None:
            return self.box
        facing = Facing(kind="normal", direction=self.normal, max_angle_deg=self.max_angle_deg)
        return Intersection(kind="intersection", of=[self.box, facing])


class ContactSettings(Section):
    """Candidate points spread over one surface against the triangles of another."""

    candidates: Name = Field(description="Surface that the candidates are spread over.")
    against: Name = Field(description="Surface that they may touch.")
    points: Annotated[int, Field(ge=1, le=100_000)] = Field(description="Number of candidates.")


class ContactRange(Section):
    """Distances of contact handling [m]."""

    alarm_distance: Distance = Field(
        default=2e-3,
        description="Distance up to which candidates and surfaces are compared [m], by default 2e-3; less "
        "than the thickness of the thinnest wall in contact.",
    )
    tolerance: Distance = Field(
        default=5e-5,
        description="Overlap beyond which a decision adds a contact column [m], by default 5e-5.",
    )


def check_surfaces(contacts: Sequence[ContactSettings], known: set[str]) -> None:
    """Raise a ValueError when a contact names a surface that is not known."""
    for index, contact in enumerate(contacts):
        for name in (contact.candidates, contact.against):
            if name not in known:
                raise ValueError(
                    f"contacts.{index}: surface {name!r} is not defined, "
                    f"known are {', '.join(sorted(known)) or 'none'}"
                )
