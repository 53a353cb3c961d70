"""The table `effectors` of a robot file: what is to reach targets."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from tauten.model.schema.region import Selection
from tauten.model.schema.section import MaxOutside, Name, Parameters, Point, Section

EffectorKind = Literal["point", "frame", "centre", "distance", "length", "volume", "function"]
Weight = Annotated[float, Field(ge=0.0, le=1e6)]

COMPONENTS: dict[EffectorKind, int] = {
    "point": 3, "centre": 3, "frame": 6, "distance": 1, "length": 1, "volume": 1, "function": 1,
}  # fmt: skip
# Fields that say what an effector is made of: of each kind those it needs, and those it may have.
_NEEDS: dict[EffectorKind, tuple[str, ...]] = {
    "point": ("point",), "centre": ("region",), "frame": (), "distance": ("point", "other"),
    "length": ("points",), "volume": (), "function": ("points", "measure"),
}  # fmt: skip
_MAY: dict[EffectorKind, tuple[str, ...]] = {
    "point": (), "centre": (), "frame": ("point", "region"), "distance": (),
    "length": ("pull_point",), "volume": ("region", "inside"), "function": ("parameters",),
}  # fmt: skip
_FIELDS = (
    "point", "other", "points", "pull_point", "region", "inside", "measure", "parameters",
)  # fmt: skip


class EffectorSettings(Section):
    """What is to reach targets: a point, frame, centre of a region, distance, length, volume or function."""

    name: Name = Field(description="Name of the effector, used once.")
    kind: EffectorKind = Field(
        default="point",
        description="What it is: a point of the body; the frame (position and orientation) of a region or, "
        "of a robot of beams alone, of the node at `point`; the centre of a region's nodes; the distance "
        "between two points; the length of a passive cable; the volume of a cavity; a function of points, a "
        "number in metres.",
    )
    point: Point | None = Field(
        default=None,
        description="The point of the body at rest that is to reach targets [m]; of a frame its origin, by "
        "default the centre of its region; of a distance the first point.",
    )
    other: Point | None = Field(
        default=None, description="Second point of the body at rest of a distance [m]."
    )
    points: list[Point] | None = Field(
        default=None,
        description="Points of the body at rest that the passive cable of a length slides through, in "
        "order [m]; of a function, its arguments.",
    )
    pull_point: Point | None = Field(
        default=None,
        description="Where the passive cable of a length starts, fixed in space [m]; by default it starts "
        "at the first of `points`.",
    )
    region: Selection | None = Field(
        default=None,
        description="Region, or the name of one, of the nodes that a frame is fitted to or a centre is the "
        "mean of; of a volume, the boundary triangles of the cavity's wall.",
    )
    inside: Point | None = Field(
        default=None, description="A point in the cavity of a volume [m], instead of `region`."
    )
    measure: Name | None = Field(
        default=None,
        description="Name of a function, an entry point of the group `tauten.effectors`, see docs/extend.md.",
    )
    parameters: Parameters | None = Field(
        default=None, description="What else the function is made with; by default nothing."
    )
    weight: Weight | Annotated[list[Weight], Field(min_length=1)] = Field(
        default=1.0,
        description="Weight in the objective, unitless, one number or one for each component: x, y, z of a "
        "position, then rotations about the frame's own axes x, y, z; 0 leaves a component free. With "
        "weight 1 a rotation by 1 rad counts like a displacement by the size of the robot, and a change "
        "of volume like the displacement of the cavity's wall that makes it.",
    )
    exact: bool = Field(
        default=False,
        description="Whether targets are to be reached exactly within a step: then the status of a "
        "decision says where that is not possible, and the nearest is done. By default targets are "
        "approached as near as possible, weighed against the energy of the actuators.",
    )
    max_outside: MaxOutside = 0.0

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        given = [field for field in _FIELDS if getattr(self, field) is not None]
        needed, allowed = _NEEDS[self.kind], (*_NEEDS[self.kind], *_MAY[self.kind])
        for field in needed:
            if field not in given:
                raise ValueError(f"{field}: needed by an effector of kind {self.kind!r}")
        for field in given:
            if field not in allowed:
                raise ValueError(
                    f"{field}: not a field of an effector of kind {self.kind!r}, "
                    f"which has {', '.join(allowed)}"
                )
        if self.kind == "frame" and not given:
            raise ValueError("region: needed by an effector of kind 'frame', on beams point")
        if self.kind == "volume" and len(given) != 1:
            raise ValueError("region: give either region or inside, where the cavity is")
        if self.kind == "length" and len(self.points or []) + (self.pull_point is not None) < 2:
            raise ValueError("points: a cable needs a pull_point or a second point")
        components = COMPONENTS[self.kind]
        if isinstance(self.weight, list) and len(self.weight) != components:
            raise ValueError(
                f"weight: {len(self.weight)} numbers, an effector of kind {self.kind!r} has "
                f"{components} components"
            )
        if not any(self.weight if isinstance(self.weight, list) else [self.weight]):
            raise ValueError("weight: all components are zero, at least one must be more")
        return self
