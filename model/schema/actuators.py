"""Actuators of a robot file other than cables: chambers, forces, couplings; and what all of them share.

Every actuator has a position δ and an effort λ that are work-conjugate: λ dδ is its work on the robot.
Limits are those of δ, of λ and of the rate of δ.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator

from tauten.model.schema.region import Selection
from tauten.model.schema.section import (
    Direction,
    Name,
    NonNegative,
    Point,
    Positive,
    Section,
    in_range,
)

Held = Literal["position", "force"]
Kind = Literal["cable", "chamber", "drive", "slide", "force"]
Pressure = Annotated[float, in_range(-1e9, 1e9, "Pa")]
Volume = Annotated[float, in_range(-1e3, 1e3, "m³")]
Length = Annotated[float, in_range(-1e3, 1e3, "m")]
Force = Annotated[float, in_range(-1e6, 1e6, "N")]
Number = Annotated[float, in_range(-1e9, 1e9, "")]
HELD = "What is kept while the node holds: the position (δ) or the force (λ)."


@dataclass(frozen=True, slots=True)
class Range:
    """Limits of one actuator: of the effort λ, of the position δ, of the rate of δ."""

    least_effort: float
    most_effort: float
    least_position: float
    most_position: float
    rate: float

    def check(self, position: str, effort: str) -> None:
        """Raise a ValueError where a limit excludes rest, at which δ and λ are zero.

        Args:
            position: name of the field of δ without `min_`, for the error.
            effort: name of the field of λ without `min_`, for the error.
        """
        pairs = (
            (position, self.least_position, self.most_position),
            (effort, self.least_effort, self.most_effort),
        )
        for name, least, most in pairs:
            if not least <= 0.0 <= most or least == most:
                raise ValueError(
                    f"min_{name} {least:g} and max_{name} {most:g} must have zero, the value at rest, "
                    "between them and must differ"
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


class ChamberSettings(Section):
    """A closed cavity of the body under pressure.

    δ is the change of its volume [m³], λ its pressure above that outside [Pa]. One of `surface`, `stl` and
    `inside` says where it is.
    """

    kind: ClassVar[Kind] = "chamber"

    name: Annotated[Name, Field(description="Name in keys, messages and tables.")]
    surface: Annotated[
        Selection | None,
        Field(description="Region of boundary triangles that encloses the chamber, or its name."),
    ] = None
    stl: Annotated[
        str | None,
        Field(
            description="STL file; the closed inner boundary of the mesh nearest to it is taken."
        ),
    ] = None
    stl_unit: Annotated[
        Literal["m", "cm", "mm"],
        Field(description="Unit of the STL file, by default m."),
    ] = "m"
    own_surface: Annotated[
        bool,
        Field(
            description="With `stl`: whether the pressure acts on the triangles of this file, which follow "
            "the elements that they lie in, instead of on the boundary of the mesh nearest to them; by "
            "default not."
        ),
    ] = False
    max_outside: Annotated[
        NonNegative,
        Field(
            le=10.0,
            description="With `own_surface`: how far outside the mesh corners of the triangles may lie [m].",
        ),
    ] = 0.0
    inside: Annotated[
        Point | None,
        Field(
            description="Point in the chamber at rest [m]; the closed inner boundary around it is taken."
        ),
    ] = None
    min_pressure: Annotated[
        Pressure,
        Field(
            description="Least pressure above that outside [Pa]; negative where vacuum is possible."
        ),
    ] = 0.0
    max_pressure: Annotated[
        Pressure, Field(description="Largest pressure above that outside [Pa].")
    ]
    min_volume_change: Annotated[
        Volume | None,
        Field(description="Least change of volume [m³]; default: −max_volume_change."),
    ] = None
    max_volume_change: Annotated[
        NonNegative, Field(le=1e3, description="Largest change of volume [m³].")
    ]
    max_rate: Annotated[
        Positive,
        in_range(0.0, 1e3, "m³/s"),
        Field(description="Largest rate of the volume [m³/s]."),
    ]
    held: Annotated[
        Held,
        Field(
            description="What is kept while the node holds: force, a supply that keeps its pressure, or "
            "position, a sealed chamber with an incompressible medium."
        ),
    ] = "force"

    @property
    def limits(self) -> Range:
        """Limits of pressure, volume change and its rate."""
        least = self.min_volume_change
        return Range(
            self.min_pressure,
            self.max_pressure,
            -self.max_volume_change if least is None else least,
            self.max_volume_change,
            self.max_rate,
        )

    @model_validator(mode="after")
    def _consistent(self) -> ChamberSettings:
        given = [name for name in ("surface", "stl", "inside") if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError(
                f"found {' and '.join(given) or 'none'} of surface, stl and inside, give one of them"
            )
        if "stl_unit" in self.model_fields_set and self.stl is None:
            raise ValueError("stl_unit is given without stl")
        if self.own_surface and self.stl is None:
            raise ValueError("own_surface is given without stl, the file that has the triangles")
        if self.max_outside and not self.own_surface:
            raise ValueError("max_outside is given without own_surface")
        self.limits.check("volume_change", "pressure")
        return self


class ForceSettings(Section):
    """A force of fixed direction on a point of the body, or spread over the nodes in a region by their mass.

    δ is the displacement along the direction [m], λ the force [N].
    """

    kind: ClassVar[Kind] = "force"

    name: Annotated[Name, Field(description="Name in keys, messages and tables.")]
    point: Annotated[Point | None, Field(description="Point it acts on, at rest [m].")] = None
    region: Annotated[
        Selection | None,
        Field(
            description="Region, or the name of one, whose nodes it acts on, spread by their mass."
        ),
    ] = None
    direction: Annotated[
        Direction, Field(description="Direction of a positive force; its length does not matter.")
    ]
    min_force: Annotated[
        Force | None, Field(description="Least force [N]; default: −max_force.")
    ] = None
    max_force: Annotated[NonNegative, Field(le=1e6, description="Largest force [N].")]
    min_travel: Annotated[
        Length | None,
        Field(description="Least displacement along the direction [m]; default: −max_travel."),
    ] = None
    max_travel: Annotated[
        NonNegative,
        Field(le=1e3, description="Largest displacement along the direction [m]."),
    ]
    max_rate: Annotated[
        Positive, in_range(0.0, 1e3, "m/s"), Field(description="Largest speed of the point [m/s].")
    ]
    held: Annotated[Held, Field(description=HELD)] = "force"
    max_outside: Annotated[
        NonNegative,
        Field(le=10.0, description="How far outside the mesh the point may lie [m]."),
    ] = 0.0

    @property
    def limits(self) -> Range:
        """Limits of force, displacement and its rate."""
        force, travel = self.min_force, self.min_travel
        return Range(
            -self.max_force if force is None else force,
            self.max_force,
            -self.max_travel if travel is None else travel,
            self.max_travel,
            self.max_rate,
        )

    @model_validator(mode="after")
    def _consistent(self) -> ForceSettings:
        if (self.point is None) == (self.region is None):
            raise ValueError("give either point or region, where the force acts")
        self.limits.check("travel", "force")
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
        position, effort = self.min_position, self.min_effort
        return Range(
            -self.max_effort if effort is None else effort,
            self.max_effort,
            -self.max_position if position is None else position,
            self.max_position,
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
    couplings: Sequence[CouplingSettings], kinds: dict[str, Kind], sprung: set[str]
) -> None:
    """Raise a ValueError where a coupling names what is no actuator, is another's, or of another kind.

    Args:
        couplings: of a robot file.
        kinds: kind of every actuator that is no coupling, by name.
        sprung: names of the cables with a spring that only pull.
    """
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
