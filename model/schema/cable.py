"""Cables of a robot file."""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field, model_validator

from tauten.model.schema.actuators import HELD, Held, Kind, Range, SpringSettings
from tauten.model.schema.section import (
    MaxOutside,
    Name,
    Point,
    Positive,
    Section,
    in_range,
)


class CableSettings(Section):
    """A cable and the limits of its winch; it starts at `pull_point` when there is one."""

    kind: ClassVar[Kind] = "cable"

    name: Name = Field(description="Name of the cable, used once.")
    points: Annotated[list[Point], Field(min_length=1)] = Field(
        description="Points of the body at rest that the cable slides through, in order [m]; it is tied to "
        "the last."
    )
    pull_point: Point | None = Field(
        default=None,
        description="Where the cable starts, fixed in space [m]; by default it starts at the first of "
        "`points`.",
    )
    min_tension: Annotated[float, in_range(-1e6, 1e6, "N")] = Field(
        default=0.0,
        description="Least tension that is decided [N], by default 0. A negative one makes a rod of the "
        "cable, which pushes too and has the length that its winch gives it.",
    )
    max_tension: Annotated[Positive, in_range(0.0, 1e6, "N")] = Field(
        description="Largest tension [N]."
    )
    min_pull: Annotated[float, in_range(-1e3, 1e3, "m")] = Field(
        default=0.0,
        description="Least pulled length [m], at most 0. The default 0 means that the winch does not pay "
        "out more cable than the robot has at rest: a cable on the outer side of a bend then holds the "
        "robot back. Give a negative value for a winch that lets cable out beyond rest.",
    )
    max_pull: Annotated[Positive, in_range(0.0, 1e3, "m")] = Field(
        description="Largest pulled length: cable wound up from rest on [m]."
    )
    max_rate: Annotated[Positive, in_range(0.0, 1e3, "m/s")] = Field(
        description="Largest speed of the winch, in and out [m/s]."
    )
    max_outside: MaxOutside = 0.0
    spring: SpringSettings | None = Field(
        default=None, description="Spring between winch and cable; default: none."
    )
    held: Held = Field(default="position", description=HELD)

    @property
    def limits(self) -> Range:
        """Limits of tension, pulled length and its rate."""
        return Range(
            self.min_tension, self.max_tension, self.min_pull, self.max_pull, self.max_rate
        )

    @model_validator(mode="after")
    def _consistent(self) -> CableSettings:
        if len(self.points) + (self.pull_point is not None) < 2:
            raise ValueError("a cable needs a pull_point or a second point")
        if self.min_tension > self.max_tension:
            raise ValueError(f"min_tension {self.min_tension} exceeds max_tension")
        if self.min_pull > 0.0 or self.min_pull >= self.max_pull:
            raise ValueError(
                f"min_pull {self.min_pull} must be at most 0, where the robot rests; negative is what the "
                "winch may let out beyond rest"
            )
        return self
