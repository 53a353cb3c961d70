"""Chambers, forces and transmissions of a robot file, and what all of its actuators share.

Every actuator has a position δ and an effort λ that are work-conjugate: λ dδ is its work on the robot.
Limits are those of δ, of λ and of the rate of δ.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator

from tauten.model.schema.region import Selection
from tauten.model.schema.section import (
    Direction,
    MaxOutside,
    Name,
    NonNegative,
    Parameters,
    Point,
    Positive,
    Section,
    in_range,
)

Held = Literal["position", "force"]
Kind = Literal[
    "cable", "chamber", "drive", "slide", "force",
    "transmission", "rotary transmission", "fluid transmission",
]  # fmt: skip
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

    @classmethod
    def about_rest(
        cls,
        effort: tuple[float | None, float],
        position: tuple[float | None, float],
        rate: float,
    ) -> Range:
        """Limits of which the least ones, where they are not given, are the largest ones with the other sign.

        Args:
            effort: least and largest.
            position: least and largest.
            rate: largest.
        """
        (low, high), (least, most) = effort, position
        return cls(
            -high if low is None else low, high, -most if least is None else least, most, rate
        )

    def check(self, position: str, effort: str) -> None:
        """Raise a ValueError where a limit excludes rest, at which δ and λ are zero.

        It names the fields of δ and of λ, which are given without `min_`.
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
        return Range.about_rest(
            (self.min_pressure, self.max_pressure),
            (self.min_volume_change, self.max_volume_change),
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
        return Range.about_rest(
            (self.min_force, self.max_force), (self.min_travel, self.max_travel), self.max_rate
        )

    @model_validator(mode="after")
    def _consistent(self) -> ForceSettings:
        if (self.point is None) == (self.region is None):
            raise ValueError("give either point or region, where the force acts")
        self.limits.check("travel", "force")
        return self


class TransmissionSettings(Section):
    """A motor that acts on points of the body through a function of them, which another package computes.

    δ is the value of the function less that at rest, λ the effort that does work on it: the force on each
    point is λ times the derivative of the function by it.
    """

    name: Annotated[Name, Field(description="Name in keys, messages and tables.")]
    function: Annotated[
        Name,
        Field(
            description="Name of the function, an entry point of the group `tauten.actuators`, see "
            "docs/extend.md."
        ),
    ]
    points: Annotated[
        list[Point] | None,
        Field(min_length=1, description="Points of the body at rest, its arguments [m]."),
    ] = None
    region: Annotated[
        Selection | None,
        Field(
            description="Region, or the name of one, whose nodes are its arguments, instead of `points`."
        ),
    ] = None
    parameters: Annotated[
        Parameters, Field(description="What else the function is made with; by default nothing.")
    ] = Field(default_factory=dict)
    unit: Annotated[
        Literal["m", "rad", "m3"],
        Field(
            description="Unit of the position; the effort is then a force [N] (m, default), a torque [N m] "
            "or a pressure [Pa]."
        ),
    ] = "m"
    min_position: Annotated[
        Number | None, Field(description="Least position; default: −max_position.")
    ] = None
    max_position: Annotated[NonNegative, Field(le=1e9, description="Largest position.")]
    min_effort: Annotated[
        Number | None, Field(description="Least effort; default: −max_effort.")
    ] = None
    max_effort: Annotated[NonNegative, Field(le=1e9, description="Largest effort.")]
    max_rate: Annotated[Positive, Field(le=1e9, description="Largest rate of the position.")]
    held: Annotated[Held, Field(description=HELD)] = "position"
    max_outside: MaxOutside = 0.0

    @property
    def kind(self) -> Kind:
        """Kind of actuator, which has its units."""
        kinds: dict[str, Kind] = {
            "m": "transmission", "rad": "rotary transmission", "m3": "fluid transmission"
        }  # fmt: skip
        return kinds[self.unit]

    @property
    def limits(self) -> Range:
        """Limits of effort, position and its rate."""
        return Range.about_rest(
            (self.min_effort, self.max_effort),
            (self.min_position, self.max_position),
            self.max_rate,
        )

    @model_validator(mode="after")
    def _consistent(self) -> TransmissionSettings:
        if (self.points is None) == (self.region is None):
            raise ValueError("give either points or region, the arguments of the function")
        self.limits.check("position", "effort")
        return self
