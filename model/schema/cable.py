"""Cables of a robot file, their springs, and motors that drive several cables or other actuators."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator

from tauten.model.schema.actuators import HELD, Held, Kind, Number, Range
from tauten.model.schema.section import (
    MaxOutside,
    Name,
    NonNegative,
    Point,
    Positive,
    Section,
    in_range,
)


class SpringSettings(Section):
    """A spring between the winch and its cable."""

    stiffness: Annotated[
        Positive, in_range(0.0, 1e9, "N/m"), Field(description="Stiffness of the spring [N/m].")
    ]
    pretension: Annotated[
        NonNegative,
        Field(le=1e6, description="Tension while winch and robot are both at rest [N]."),
    ] = 0.0


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


class CouplingSettings(Section):
    """One motor that drives several actuators of the same kind, its members.

    Of a differential the position is δ_m = Σ g_i δ_i and the effort on member i is
    λ_i = pretension_i + g_i λ_m, with the gain g_i. A drum winds its cables to the lengths g_i δ_m, and their
    tensions differ: its effort is λ_m = Σ g_i λ_i. Limits, decision and messages are in the motor's
    coordinate; the limits of the members' efforts hold for a differential too.
    """

    name: Annotated[Name, Field(description="Name in keys, messages and tables.")]
    kind: Annotated[
        Literal["differential", "drum"],
        Field(
            description="Whether the members share the motor's effort (differential, default), or are cables "
            "that it winds together (drum), each with a `spring`."
        ),
    ] = "differential"
    members: Annotated[
        list[Name], Field(min_length=1, description="Names of the actuators that it drives.")
    ]
    gains: Annotated[
        list[Number], Field(min_length=1, description="Gain of each member, signed, not zero.")
    ]
    pretensions: Annotated[
        list[Number] | None,
        Field(
            description="Effort on each member where the motor has none [N, Pa]; default: zeros."
        ),
    ] = None
    min_position: Annotated[
        Number | None, Field(description="Least position; default: −max_position.")
    ] = None
    max_position: Annotated[
        NonNegative, Field(le=1e9, description="Largest position, in the members' unit.")
    ]
    min_effort: Annotated[
        Number | None, Field(description="Least effort; default: −max_effort.")
    ] = None
    max_effort: Annotated[
        NonNegative, Field(le=1e9, description="Largest effort, in the members' unit.")
    ]
    max_rate: Annotated[Positive, Field(le=1e9, description="Largest rate of the position.")]
    held: Annotated[Held, Field(description=HELD)] = "position"

    @property
    def limits(self) -> Range:
        """Limits of the motor alone."""
        return Range.about_rest(
            (self.min_effort, self.max_effort),
            (self.min_position, self.max_position),
            self.max_rate,
        )

    @property
    def offsets(self) -> list[float]:
        """Efforts on the members where the motor has none."""
        return [0.0] * len(self.members) if self.pretensions is None else self.pretensions

    @model_validator(mode="after")
    def _consistent(self) -> CouplingSettings:
        for name, values in (("gains", self.gains), ("pretensions", self.offsets)):
            if len(values) != len(self.members):
                raise ValueError(f"found {len(values)} {name} for {len(self.members)} members")
        if not all(abs(gain) > 1e-9 for gain in self.gains):
            raise ValueError(f"gains {self.gains} must all be at least 1e-9 in magnitude")
        if len(set(self.members)) < len(self.members):
            raise ValueError(f"members {self.members} name an actuator twice")
        if self.kind == "drum" and self.pretensions is not None:
            raise ValueError(
                "pretensions: the cables of a drum have theirs in `spring`, leave it out"
            )
        self.limits.check("position", "effort")
        return self


def check_couplings(
    couplings: Sequence[CouplingSettings], kinds: Mapping[str, str], sprung: set[str]
) -> None:
    """Raise a ValueError where a coupling names what is no actuator, is another's, or of another kind."""
    taken: set[str] = set()
    for index, coupling in enumerate(couplings):
        for name in coupling.members:
            if name not in kinds:
                raise ValueError(
                    f"couplings.{index}: member {name!r} is not defined, known are {', '.join(kinds)}"
                )
            if name in taken:
                raise ValueError(
                    f"couplings.{index}: member {name!r} is driven by another coupling"
                )
            if kinds[name] != kinds[coupling.members[0]]:
                raise ValueError(
                    f"couplings.{index}: {name!r} is a {kinds[name]} and {coupling.members[0]!r} a "
                    f"{kinds[coupling.members[0]]}, the members of a coupling are of one kind"
                )
            if coupling.kind == "drum" and name not in sprung:
                raise ValueError(
                    f"couplings.{index}: {name!r} on a drum has to be a cable with a spring, whose stiffness "
                    "takes up what the drum winds, and with a min_tension of 0 or more"
                )
        taken.update(coupling.members)
