"""The robot file, a TOML file, validated field by field."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import ConfigDict, Field, model_validator

from tauten.model.schema.actuators import (
    HELD,
    ChamberSettings,
    CouplingSettings,
    ForceSettings,
    Held,
    Kind,
    Range,
    SpringSettings,
    check_couplings,
)
from tauten.model.schema.material import (
    MaterialSettings,
    RegionMaterialSettings,
    SolidMaterialSettings,
)
from tauten.model.schema.section import (
    Box,
    Direction,
    Distance,
    Name,
    NonNegative,
    Point,
    Positive,
    Rate,
    Section,
    in_range,
)

ElementName = Literal["linear", "quadratic", "smoothed"]
BackEnd = Literal["auto", "pardiso", "cholmod", "superlu"]
Acceleration = Annotated[float, in_range(-1e3, 1e3, "m/s²")]
Gravity = tuple[Acceleration, Acceleration, Acceleration]


class MeshSettings(Section):
    """The body's mesh; `length_unit` applies to the mesh file only, the robot file is in SI units.

    `element` is what the body is made of: linear tetrahedra; quadratic ones, with midpoints added to a linear
    mesh; or linear ones with strain smoothed around edges and change of volume around nodes.
    """

    file: str
    length_unit: Literal["m", "cm", "mm"] = "m"
    element: ElementName = "linear"


class CableSettings(Section):
    """A cable and the limits of its winch; it starts at `pull_point` when there is one."""

    kind: ClassVar[Kind] = "cable"

    name: Name
    points: Annotated[list[Point], Field(min_length=1)]
    pull_point: Point | None = None
    min_tension: NonNegative = 0.0
    max_tension: Annotated[Positive, in_range(0.0, 1e6, "N")]
    min_pull: Annotated[float, in_range(-1e3, 1e3, "m")] = 0.0
    max_pull: Annotated[Positive, in_range(0.0, 1e3, "m")]
    max_rate: Annotated[Positive, in_range(0.0, 1e3, "m/s")]
    max_outside: Annotated[NonNegative, Field(le=10.0)] = 0.0
    spring: Annotated[
        SpringSettings | None, Field(description="Spring between winch and cable; default: none.")
    ] = None
    held: Annotated[Held, Field(description=HELD)] = "position"

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
            raise ValueError(f"min_pull {self.min_pull} must be at most 0, where the robot rests")
        return self


SingleActuator = CableSettings | ChamberSettings | ForceSettings


class EffectorSettings(Section):
    """A point of the body that is to reach targets."""

    name: Name
    point: Point
    max_outside: Annotated[NonNegative, Field(le=10.0)] = 0.0


class SurfaceSettings(Section):
    """Boundary triangles whose centre lies in the box and whose normal points along `normal`."""

    name: Name
    box: Box
    normal: Direction | None = None
    max_angle_deg: Annotated[float, Field(gt=0.0, le=180.0)] = 45.0


class ContactSettings(Section):
    """Candidate points spread over one surface against the triangles of another."""

    candidates: Name
    against: Name
    points: Annotated[int, Field(ge=1, le=100_000)]


class ContactRange(Section):
    """Distances of contact handling [m]."""

    alarm_distance: Distance = 2e-3
    tolerance: Distance = 5e-5


class IntegrationSettings(Section):
    """Time integration; the time step is `ControlPeriod`."""

    scheme: Literal["implicit-euler", "quasi-static"] = "implicit-euler"
    rayleigh_mass: Annotated[NonNegative, Field(le=1e6)] = 0.0
    rayleigh_stiffness: Annotated[NonNegative, Field(le=1e3)] = 0.0
    factorisation: BackEnd = "auto"


class ControlPeriod(Section):
    """What the model reads of the table `controller`: a time step is one control period, 1 / `rate` [Hz]."""

    model_config = ConfigDict(extra="ignore")

    rate: Rate = 50.0


class Changes(Section):
    """The arguments with which `load_robot` changes a robot file."""

    rate: Rate | None = None
    refinements: Annotated[int, Field(ge=0, le=4)] = 0
    factorisation: BackEnd | None = None
    young_scale: Annotated[float, in_range(1e-6, 1e6, "")] = 1.0


# Tables of a robot file that other layers read. They read `controller` too, the model only its rate.
OTHER_LAYERS = ("model", "service")


def model_tables(raw: dict[str, Any]) -> dict[str, Any]:
    """The contents of a robot file without what other layers read; the control rate is kept."""
    return {key: value for key, value in raw.items() if key not in OTHER_LAYERS}


class RobotSettings(Section):
    """The fields of the model in every robot file, for all kinds of bodies."""

    name: Name
    frame: Name = "base"
    gravity: Gravity = (0.0, 0.0, -9.81)
    material: MaterialSettings
    fixed: Annotated[list[Box], Field(min_length=1)]
    cables: tuple[CableSettings, ...] = ()
    chambers: Annotated[
        tuple[ChamberSettings, ...], Field(description="Closed cavities under pressure.")
    ] = ()
    forces: Annotated[
        tuple[ForceSettings, ...], Field(description="Forces of fixed direction on the body.")
    ] = ()
    couplings: Annotated[
        tuple[CouplingSettings, ...], Field(description="Motors that drive several actuators each.")
    ] = ()
    effectors: Annotated[list[EffectorSettings], Field(min_length=1)]
    contacts: tuple[ContactSettings, ...] = ()
    contact: ContactRange = ContactRange()
    integration: IntegrationSettings = IntegrationSettings()
    controller: ControlPeriod = ControlPeriod()

    @model_validator(mode="after")
    def _names_once(self) -> Self:
        check_unique("cables", [cable.name for cable in self.cables])
        check_unique("effectors", [effector.name for effector in self.effectors])
        single = self.single_actuators
        if not single:
            raise ValueError("a robot needs an actuator: a table cables, chambers or forces")
        check_unique("actuators", [item.name for item in (*single, *self.couplings)])
        check_couplings(self.couplings, {item.name: item.kind for item in single})
        return self

    @property
    def single_actuators(self) -> tuple[SingleActuator, ...]:
        """All actuators but couplings: cables, chambers, forces as listed."""
        return (*self.cables, *self.chambers, *self.forces)

    @property
    def actuators(self) -> tuple[SingleActuator | CouplingSettings, ...]:
        """In the order of λ_a: a coupling stands where its first member stood, the others vanish."""
        coupling_of = {name: item for item in self.couplings for name in item.members}
        found = (coupling_of.get(item.name, item) for item in self.single_actuators)
        return tuple({item.name: item for item in found}.values())


class RobotConfig(RobotSettings):
    """The file of a robot made of tetrahedra."""

    material: SolidMaterialSettings
    materials: tuple[RegionMaterialSettings, ...] = ()
    mesh: MeshSettings
    surfaces: tuple[SurfaceSettings, ...] = ()

    @model_validator(mode="after")
    def _surfaces(self) -> RobotConfig:
        check_unique("surfaces", [surface.name for surface in self.surfaces])
        check_surfaces(self.contacts, {surface.name for surface in self.surfaces})
        return self


def check_unique(what: str, names: list[str]) -> None:
    """Raise a ValueError when a name is used twice."""
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ValueError(f"{what}: name {twice[0]!r} is used twice")


def check_surfaces(contacts: Sequence[ContactSettings], known: set[str]) -> None:
    """Raise a ValueError when a contact names a surface that is not known."""
    for index, contact in enumerate(contacts):
        for name in (contact.candidates, contact.against):
            if name not in known:
                raise ValueError(
                    f"contacts.{index}: surface {name!r} is not defined, "
                    f"known are {', '.join(sorted(known)) or 'none'}"
                )
