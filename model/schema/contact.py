"""Surfaces, obstacles and contacts of a robot file."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Annotated, Literal, Self, TypeAlias

from pydantic import Field, model_validator

from tauten.model.schema.body import RotationSettings
from tauten.model.schema.region import Box, Facing, Intersection, Region
from tauten.model.schema.section import (
    Direction,
    Distance,
    Name,
    NonNegative,
    Parameters,
    Point,
    Section,
    in_range,
)

ITSELF = "itself"  # instead of the name of a surface: the surface of the candidates
ALARM_DISTANCE = 2e-3  # m, by default between surfaces with names
LARGEST_FRICTION = 100.0  # beyond it a contact that sticks is not told from one that is glued
LARGEST_FORCE = 1e6  # N
SHORTEST_LEG = 1e-3  # s, between two waypoints
LEAST_COSINE, ROUNDING = 1e-9, 1e-12  # of half the angle between rotations
SHAPE_NAME = r"^[A-Za-z][A-Za-z0-9_-]*$"


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


class WaypointSettings(Section):
    """Where an obstacle is at a time."""

    time: Annotated[NonNegative, Field(le=1e6)] = Field(
        description="Time from the start [s]; that of the first waypoint is 0."
    )
    position: Point = Field(
        default=(0.0, 0.0, 0.0),
        description="Where the origin of the obstacle's frame is [m], by default in the robot's origin.",
    )
    rotation: RotationSettings | None = Field(
        default=None, description="Rotation of the frame about its origin; by default none."
    )

    def half_angle_cosine(self, other: WaypointSettings) -> float:
        """Cosine of half the angle between both rotations; below zero where it exceeds 180°."""
        ways = [
            (1.0, 0.0, 0.0, 0.0) if one.rotation is None else one.rotation.unit_quaternion
            for one in (self, other)
        ]
        cosine: float = sum(a * b for a, b in zip(*ways, strict=True))
        return cosine


class ObstaclePathSettings(Section):
    """A motion of an obstacle, which is even between waypoints, and turns by less than 180 degrees there."""

    waypoints: Annotated[tuple[WaypointSettings, ...], Field(min_length=2, max_length=10_000)] = (
        Field(description="Two or more, with ascending times.")
    )
    loop: bool = Field(
        default=False,
        description="Whether the motion starts again after the last waypoint, which is then where the first "
        "one is (360 degrees are 0); by default the obstacle stays at the last one.",
    )

    @model_validator(mode="after")
    def _runs_forward(self) -> ObstaclePathSettings:
        times = [one.time for one in self.waypoints]
        if times[0] != 0.0 or any(b - a < SHORTEST_LEG for a, b in pairwise(times)):
            raise ValueError(
                f"the times of waypoints start with 0 and ascend by at least {SHORTEST_LEG:g} s, found "
                f"{', '.join(f'{one:g}' for one in times[:5])}{', ...' if len(times) > 5 else ''}"
            )
        for number, (one, other) in enumerate(pairwise(self.waypoints)):
            free = any(item.rotation and item.rotation.quaternion for item in (one, other))
            if not free and one.half_angle_cosine(other) < LEAST_COSINE:
                raise ValueError(
                    f"between waypoints {number} and {number + 1} the obstacle turns by 180 degrees or more, "
                    "and would take the shorter way: put a waypoint between them"
                )
        first, last = self.waypoints[0], self.waypoints[-1]
        turned = abs(first.half_angle_cosine(last)) < 1.0 - ROUNDING
        if self.loop and (first.position != last.position or turned):
            raise ValueError("a path with loop ends where it starts: repeat the first waypoint")
        return self


class PoseStreamSettings(Section):
    """Poses of an obstacle that may arrive at run time."""

    largest_speed: Annotated[float, in_range(0.0, 100.0, "m/s")] = Field(
        description="Largest speed of the obstacle's origin [m/s]; poses that are farther away than it "
        "travels are refused."
    )
    largest_spin_deg: Annotated[float, in_range(0.0, 36_000.0, "deg/s")] = Field(
        default=360.0, description="Likewise of its turning [deg/s], by default 360."
    )
    timeout: Annotated[float, in_range(1e-3, 60.0, "s")] = Field(
        default=0.3,
        description="Time without a pose after which the obstacle stands still where it is [s], by default "
        "0.3, and three periods of the controller at least; older poses are refused.",
    )


class ObstacleSettings(Section):
    """A shape that the robot may touch; contacts name it in `against`."""

    name: Name = Field(description="Name of the obstacle, used once and by no surface or region.")
    shape: Annotated[str, Field(pattern=SHAPE_NAME)] = Field(
        description="Name of the shape: `plane` with the parameters `point` and `normal`, `sphere` with "
        "`centre` and `radius`, `capsule` and `cylinder` with `start`, `end` and `radius`, `box` with "
        "`lower` and `upper`, `mesh` with `file` and `length_unit`, `height-field` with `corner`, `spacing`, "
        "`thickness` and `heights` or `file`, or an entry point of the group `tauten.contact_shapes`, see "
        "docs/contact.md and docs/extend.md."
    )
    parameters: Parameters = Field(
        default_factory=dict, description="What the shape is made with [m]; by default nothing."
    )
    position: Point = Field(
        default=(0.0, 0.0, 0.0),
        description="Where the origin of the shape's frame is [m], by default in the robot's origin.",
    )
    rotation: RotationSettings | None = Field(
        default=None, description="Rotation of the shape's frame about its origin; by default none."
    )
    path: ObstaclePathSettings | None = Field(
        default=None, description="Along which it moves, instead of a position; by default none."
    )
    stream: PoseStreamSettings | None = Field(
        default=None,
        description="What poses may arrive at run time on `tauten/<robot>/obstacle/<name>`; by default none.",
    )
    max_force: Annotated[float, in_range(0.0, LARGEST_FORCE, "N")] | None = Field(
        default=None,
        description="Sum of the normal forces of all contacts on the obstacle [N] that decisions keep at "
        "most, by default any.",
    )

    @model_validator(mode="after")
    def _one_motion(self) -> ObstacleSettings:
        if self.path is None:
            return self
        if self.stream is not None:
            raise ValueError("an obstacle has a path or a stream, not both")
        if "position" in self.model_fields_set or self.rotation is not None:
            raise ValueError(
                "path: where it starts is its first waypoint, without a position beside"
            )
        return self


Points: TypeAlias = Annotated[
    Annotated[int, Field(ge=1, le=100_000)] | Literal["vertices"] | None,
    Field(
        description="Number of candidates, or `vertices` for one at each vertex of the surface; by default "
        "one for each square of a mean edge."
    ),
]
Spacing: TypeAlias = Annotated[
    Distance | None,
    Field(
        description="Instead of `points`: candidates at each vertex of the surface, along its edges and over "
        "its area, so far from each other at most [m]. What is wider does not pass between them, and a body "
        "stands on them as far as its edges reach."
    ),
]


class TouchSettings(Section):
    """What every contact may have, whatever touches."""

    friction: Annotated[NonNegative, Field(le=LARGEST_FRICTION)] = Field(
        default=0.0,
        description="Coefficient of Coulomb friction of the contact, 0 to 100; by default 0.",
    )
    min_force: Annotated[NonNegative, Field(le=LARGEST_FORCE)] = Field(
        default=0.0,
        description="Sum of the normal forces of the contact [N] that decisions keep at least, once it "
        "has pushed with a tenth of it: a grasp is not let go before the command `let-go`. By default 0.",
    )
    max_force: Annotated[float, in_range(0.0, LARGEST_FORCE, "N")] | None = Field(
        default=None,
        description="Sum of the normal forces of the contact [N] that decisions keep at most, by default "
        "any.",
    )
    min_slip_margin: Annotated[NonNegative, Field(le=LARGEST_FORCE)] = Field(
        default=0.0,
        description="Distance to slip of the contact [N] that decisions keep at least: the coefficient "
        "of friction times the sum of its normal forces, less the sum of its forces of friction. It counts "
        "once the contact has pushed with a tenth of min_slip_margin / friction, up to the command `let-go`. "
        "By default 0.",
    )

    @model_validator(mode="after")
    def _forces_are_possible(self) -> Self:
        if self.max_force is not None and self.min_force > self.max_force:
            raise ValueError(
                f"min_force {self.min_force:g} N must be at most max_force {self.max_force:g} N"
            )
        if self.min_slip_margin > 0.0 and self.friction == 0.0:
            raise ValueError(
                "min_slip_margin needs a friction above 0: without it everything slips"
            )
        if self.max_force is not None and self.least_force > self.max_force:
            raise ValueError(
                f"min_slip_margin {self.min_slip_margin:g} N with a friction of {self.friction:g} needs a "
                f"normal force of {self.least_force:g} N, and max_force is {self.max_force:g} N"
            )
        return self

    @property
    def least_force(self) -> float:
        """Sum of the normal forces without which its limits cannot be kept, once it pushes [N]."""
        margin = self.min_slip_margin
        return max(self.min_force, margin / self.friction if margin > 0.0 else 0.0)


class ContactSettings(TouchSettings):
    """Candidate points spread over a surface against another one, against itself, or against an obstacle."""

    candidates: Name | None = Field(
        default=None,
        description='Surface or region that the candidates are spread over; where `against` is "itself" '
        "or an obstacle it may be left out, which means the whole surface of the robot.",
    )
    against: Name = Field(
        description='Surface, region or obstacle that they may touch; "itself" means the surface of the '
        "candidates, without the neighbourhood of each candidate."
    )
    points: Points = None
    spacing: Spacing = None
    neighbour_distance: Distance | None = Field(
        default=None,
        description='With `against = "itself"`: way along the surface at rest within which parts of it are '
        "never compared [m]; by default two mean edges of the surface, and no less than two alarm distances.",
    )

    @model_validator(mode="after")
    def _consistent(self) -> ContactSettings:
        one_way_to_place_points(self.points, self.spacing)
        if self.against != ITSELF and self.neighbour_distance is not None:
            raise ValueError('neighbour_distance is used with against = "itself" only')
        return self

    @property
    def name(self) -> str:
        """What the pair is called in messages."""
        return f"{self.candidates or 'skin'} on {self.against}"


def one_way_to_place_points(points: int | str | None, spacing: float | None) -> None:
    """Raise a ValueError where a contact has both."""
    if points is not None and spacing is not None:
        raise ValueError("give points or spacing, not both")


class ContactRange(Section):
    """Distances of contact handling [m], and the largest force of all contacts."""

    alarm_distance: Distance | None = Field(
        default=None,
        description="Distance up to which candidates and surfaces are compared [m], less than the thickness "
        "of the thinnest wall between two surfaces with names; by default 2e-3, and where a surface may "
        "touch itself half its mean edge.",
    )
    distance: Annotated[NonNegative, Field(le=1.0)] = Field(
        default=0.0,
        description="Distance from each other at which surfaces are held [m], by default 0; less than the "
        "alarm distance, whose default grows by it. SOFA's contactDistance.",
    )
    tolerance: Distance = Field(
        default=5e-5,
        description="Overlap beyond which a decision adds a contact column [m], by default 5e-5.",
    )
    max_force: Annotated[float, in_range(0.0, LARGEST_FORCE, "N")] | None = Field(
        default=None,
        description="Sum of the normal forces of all contacts [N] that decisions keep at most, by default "
        "any.",
    )

    @model_validator(mode="after")
    def _held_within_reach(self) -> ContactRange:
        if self.alarm_distance is not None and self.distance >= self.alarm_distance:
            raise ValueError(
                f"distance {self.distance:g} m must be less than alarm_distance {self.alarm_distance:g} m"
            )
        return self


def check_surfaces(
    contacts: Sequence[ContactSettings], known: set[str], obstacles: Sequence[str]
) -> None:
    """Raise a ValueError when a contact names what is not known, or when names do not tell things apart."""
    if ITSELF in known.union(obstacles):
        raise ValueError(f"no surface, region or obstacle may have the name {ITSELF!r}")
    for obstacle in obstacles:
        if obstacle in known:
            raise ValueError(f"obstacles: {obstacle!r} is the name of a surface or region too")
    for index, contact in enumerate(contacts):
        if contact.candidates is None and contact.against not in (ITSELF, *obstacles):
            raise ValueError(
                f'contacts.{index}: candidates are missing; only against = "itself" or an obstacle goes '
                f"without them, found {contact.against!r}, obstacles are {', '.join(obstacles) or 'none'}"
            )
        named: list[tuple[str | None, set[str]]] = [
            (contact.candidates, known),
            (contact.against, known.union(obstacles)),
        ]
        for name, allowed in named:
            if name is not None and name != ITSELF and name not in allowed:
                raise ValueError(
                    f"contacts.{index}: surface {name!r} is not defined, "
                    f"known are {', '.join(sorted(allowed)) or 'none'}"
                )


def check_pairs(names: Sequence[str]) -> None:
    """Raise a ValueError where two contacts are of the same pair, whose forces have one name in messages."""
    for index, name in enumerate(names):
        first = names.index(name)
        if first < index:
            raise ValueError(
                f"contacts.{index}: it is {name!r} as contacts.{first} is; write one table for both"
            )


def check_forces(
    contacts: Sequence[tuple[TouchSettings, object]],
    obstacles: Sequence[ObstacleSettings],
    contact: ContactRange,
) -> None:
    """Make sure that contacts together may push as much as each of them is to.

    Raises:
        ValueError: they may not.
    """
    for number, obstacle in enumerate(obstacles):
        own = [one.least_force for one, against in contacts if against == obstacle.name]
        if obstacle.max_force is not None and sum(own) > obstacle.max_force:
            raise ValueError(
                f"obstacles.{number}.max_force is {obstacle.max_force:g} N, and min_force and "
                f"min_slip_margin of the contacts against {obstacle.name} need {sum(own):g} N when all of "
                "them push; expected at least that"
            )
    least, largest = sum(one.least_force for one, _ in contacts), contact.max_force
    if largest is not None and least > largest:
        raise ValueError(
            f"contact.max_force is {largest:g} N, and min_force and min_slip_margin of the contacts need "
            f"{least:g} N when all of them push; expected at least that"
        )
