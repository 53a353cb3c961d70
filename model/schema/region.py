"""Regions of a robot file: what selects nodes, boundary triangles or tetrahedra.

A region has one of the kinds below. It is written where it is used, or once in `[[regions]]` and used by
its name.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from tauten.model.schema.section import Direction, Name, Point, Positive, Section


class Region(Section):
    """What all kinds have in common."""

    name: Annotated[
        Name | None, Field(description="Name by which it is used; needed in `[[regions]]`.")
    ] = None
    body: Annotated[
        Name | None,
        Field(
            description="Body of `[[bodies]]` that it selects from; its coordinates are then those of this "
            "body's mesh before the pose, in metres. Without it the whole robot, in the robot's frame."
        ),
    ] = None


class Box(Region):
    """What lies between two corners [m], its faces included."""

    kind: Literal["box"] = Field(default="box", description="Kind of region; a box by default.")
    lower: Annotated[
        tuple[float, float, float], Field(description="Corner with the smallest coordinates [m].")
    ]
    upper: Annotated[
        tuple[float, float, float], Field(description="Corner with the largest coordinates [m].")
    ]

    @model_validator(mode="after")
    def _ordered(self) -> Box:
        if any(low > high for low, high in zip(self.lower, self.upper, strict=True)):
            raise ValueError(f"lower {self.lower} must not exceed upper {self.upper}")
        return self


class Sphere(Region):
    """What lies within a distance of a point."""

    kind: Literal["sphere"] = Field(description="Kind of region.")
    centre: Annotated[Point, Field(description="Centre [m].")]
    radius: Annotated[Positive, Field(description="Radius [m].")]


class Cylinder(Region):
    """What lies within a distance of the line between two points, its flat ends included."""

    kind: Literal["cylinder"] = Field(description="Kind of region.")
    start: Annotated[Point, Field(description="Centre of one flat end [m].")]
    end: Annotated[Point, Field(description="Centre of the other flat end [m].")]
    radius: Annotated[Positive, Field(description="Radius [m].")]

    @model_validator(mode="after")
    def _long(self) -> Cylinder:
        if self.start == self.end:
            raise ValueError(f"start and end are both {self.start}, a cylinder has a length")
        return self


class HalfSpace(Region):
    """What lies on the side of a plane that its normal points to, the plane included."""

    kind: Literal["half_space"] = Field(description="Kind of region.")
    point: Annotated[Point, Field(description="A point of the plane [m].")]
    normal: Annotated[Direction, Field(description="Direction towards what is selected.")]


class NamedGroup(Region):
    """A physical group or set of the mesh file, or the cells with a value of one of its cell arrays."""

    kind: Literal["group"] = Field(description="Kind of region.")
    group: Annotated[
        str,
        Field(
            min_length=1,
            description='Name of the group; "ARRAY:VALUE" for an array of integers on the cells.',
        ),
    ]


class NumberedNodes(Region):
    """Nodes by their numbers in the mesh file, and the triangles and tetrahedra that have no other corners.

    Where the mesh is refined, nodes between two of these are selected too.
    """

    kind: Literal["nodes"] = Field(description="Kind of region.")
    numbers: Annotated[
        list[Annotated[int, Field(ge=0)]],
        Field(min_length=1, description="Numbers of the nodes in the mesh file, counted from 0."),
    ]


class NearStl(Region):
    """Boundary triangles whose centre lies near the surface in an STL file."""

    kind: Literal["near_stl"] = Field(description="Kind of region.")
    file: Annotated[str, Field(description="The STL file, relative to the robot file.")]
    length_unit: Annotated[
        Literal["m", "cm", "mm"], Field(description="Unit of its coordinates.")
    ] = "m"
    distance: Annotated[
        Positive | None,
        Field(
            description="Largest distance [m]; without it a quarter of the mean edge on the boundary."
        ),
    ] = None


class Skin(Region):
    """All boundary triangles, the walls of cavities included."""

    kind: Literal["skin"] = Field(description="Kind of region.")


class Everything(Region):
    """All of the mesh, or of `body`."""

    kind: Literal["all"] = Field(description="Kind of region.")


class Facing(Region):
    """Boundary triangles whose outward normal points along a direction."""

    kind: Literal["normal"] = Field(description="Kind of region.")
    direction: Annotated[Direction, Field(description="The direction.")]
    max_angle_deg: Annotated[
        float, Field(gt=0.0, le=180.0, description="Largest angle between the two [degrees].")
    ] = 45.0


class Union(Region):
    """What any of several regions selects."""

    kind: Literal["union"] = Field(description="Kind of region.")
    of: Annotated[list[Selection], Field(min_length=1, description="The regions, or their names.")]


class Intersection(Region):
    """What all of several regions select."""

    kind: Literal["intersection"] = Field(description="Kind of region.")
    of: Annotated[list[Selection], Field(min_length=1, description="The regions, or their names.")]


class Difference(Region):
    """What the first of several regions selects and none of the others does."""

    kind: Literal["difference"] = Field(description="Kind of region.")
    of: Annotated[list[Selection], Field(min_length=2, description="The regions, or their names.")]


KINDS = (
    "box", "sphere", "cylinder", "half_space", "group", "nodes", "near_stl", "skin", "all", "normal", "union",
    "intersection", "difference",
)  # fmt: skip


def kind_of(value: Any) -> str | None:
    """The tag of a selection, as it stands in the file or validated; a table without `kind` is a box."""
    if isinstance(value, str):
        return "<name>"
    kind = value.get("kind", "box") if isinstance(value, dict) else getattr(value, "kind", None)
    return f"<{kind}>" if kind in KINDS else None


# Tags in angle brackets: `validated` leaves them out of the names of fields.
Tagged = (
    Annotated[Box, Tag("<box>")]
    | Annotated[Sphere, Tag("<sphere>")]
    | Annotated[Cylinder, Tag("<cylinder>")]
    | Annotated[HalfSpace, Tag("<half_space>")]
    | Annotated[NamedGroup, Tag("<group>")]
    | Annotated[NumberedNodes, Tag("<nodes>")]
    | Annotated[NearStl, Tag("<near_stl>")]
    | Annotated[Skin, Tag("<skin>")]
    | Annotated[Everything, Tag("<all>")]
    | Annotated[Facing, Tag("<normal>")]
    | Annotated[Union, Tag("<union>")]
    | Annotated[Intersection, Tag("<intersection>")]
    | Annotated[Difference, Tag("<difference>")]
)
AnyRegion = Annotated[
    Tagged,
    Discriminator(
        kind_of,
        custom_error_type="region",
        custom_error_message=f"a region has a kind of {', '.join(KINDS)}",
    ),
]
Selection = Annotated[
    Annotated[Name, Tag("<name>")] | Tagged,
    Discriminator(
        kind_of,
        custom_error_type="region",
        custom_error_message="a region is the name of one, or a table with a kind of "
        f"{', '.join(KINDS)}",
    ),
]

for _combined in (Union, Intersection, Difference):
    _combined.model_rebuild()


def names_used(selection: Region | str) -> Iterator[str]:
    """Names of the regions that a selection uses directly."""
    if isinstance(selection, str):
        yield selection
    elif isinstance(selection, Union | Intersection | Difference):
        for part in selection.of:
            yield from names_used(part)


def check_regions(named: dict[str, Region], used: list[tuple[str, Region | str]]) -> None:
    """Raise a ValueError for a name that no region has, and for regions made of themselves."""
    for field, selection in [
        *((f"regions.{name}", region) for name, region in named.items()),
        *used,
    ]:
        for name in names_used(selection):
            if name not in named:
                known = ", ".join(sorted(named)) or "none"
                raise ValueError(f"{field}: region {name!r} is not defined, known are {known}")
    for name in named:
        reached, open_names = set(), [name]
        while open_names:
            for following in names_used(named[open_names.pop()]):
                if following == name:
                    raise ValueError(f"regions.{name}: it is made of itself")
                if following not in reached:
                    reached.add(following)
                    open_names.append(following)
