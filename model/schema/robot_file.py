"""The robot file: what a TOML file may say about a robot, validated field by field."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Annotated, Any, Literal, Self, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

Vector = tuple[float, float, float]
Positive = Annotated[float, Field(gt=0.0)]
NonNegative = Annotated[float, Field(ge=0.0)]
Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$")]


class RobotFileError(ValueError):
    """A robot file that cannot be used; the text names file, field, what was found and allowed."""


class Section(BaseModel):
    """A table of the robot file: unknown keys and non-finite numbers are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


S = TypeVar("S", bound=Section)


class MeshSettings(Section):
    """The body's mesh; `length_unit` is that of the mesh file alone, this file is in SI."""

    file: str
    length_unit: Literal["m", "cm", "mm"] = "m"


class MaterialSettings(Section):
    """Isotropic material."""

    young_modulus: Annotated[float, Field(ge=1e2, le=1e12)]
    poisson_ratio: Annotated[float, Field(ge=0.0, lt=0.5)]
    density: Annotated[float, Field(ge=1.0, le=3e4)]


class Box(Section):
    """Nodes or triangles between two corners [m]."""

    lower: Vector
    upper: Vector

    @model_validator(mode="after")
    def _ordered(self) -> Box:
        if any(low > high for low, high in zip(self.lower, self.upper, strict=True)):
            raise ValueError(f"lower {self.lower} must not exceed upper {self.upper}")
        return self


class CableSettings(Section):
    """A cable and what its winch can do; it starts at `pull_point` when there is one."""

    name: Name
    points: Annotated[list[Vector], Field(min_length=1)]
    pull_point: Vector | None = None
    min_tension: NonNegative = 0.0
    max_tension: Positive
    min_pull: float = 0.0
    max_pull: Positive
    max_rate: Positive
    max_outside: NonNegative = 0.0

    @model_validator(mode="after")
    def _consistent(self) -> CableSettings:
        if len(self.points) + (self.pull_point is not None) < 2:
            raise ValueError("a cable needs a pull_point or a second point")
        if self.min_tension > self.max_tension:
            raise ValueError(f"min_tension {self.min_tension} exceeds max_tension")
        if self.min_pull > 0.0 or self.min_pull >= self.max_pull:
            raise ValueError(f"min_pull {self.min_pull} must be at most 0, where the robot rests")
        return self


class EffectorSettings(Section):
    """A point of the body that is to reach targets."""

    name: Name
    point: Vector
    max_outside: NonNegative = 0.0


class SurfaceSettings(Section):
    """Boundary triangles whose centre lies in the box and whose normal points along `normal`."""

    name: Name
    box: Box
    normal: Vector | None = None
    max_angle_deg: Annotated[float, Field(gt=0.0, le=180.0)] = 45.0


class ContactSettings(Section):
    """Candidate points spread over one surface against the triangles of another."""

    candidates: Name
    against: Name
    points: Annotated[int, Field(ge=1, le=100_000)]


class ContactRange(Section):
    """Distances of contact handling [m]."""

    alarm_distance: Positive = 2e-3
    tolerance: Positive = 5e-5


class IntegrationSettings(Section):
    """Time integration; the step is 1 / controller.rate."""

    scheme: Literal["implicit-euler", "quasi-static"] = "implicit-euler"
    rayleigh_mass: NonNegative = 0.0
    rayleigh_stiffness: NonNegative = 0.0
    factorisation: Literal["auto", "pardiso", "cholmod", "superlu"] = "auto"


class ControllerSettings(Section):
    """Inverse control: rate [Hz], the QP back end, the weight ε of (T1), the contact basis."""

    rate: Annotated[float, Field(gt=0.0, le=10_000.0)] = 50.0
    qp_solver: Name = "daqp"
    regularisation: NonNegative = 1e-3
    basis: str | None = None
    max_pivots: Annotated[int, Field(ge=1)] = 100


class ModelSettings(Section):
    """Which model decides: the full one, or that of a state basis with its sample of elements.

    `states` names the basis, and `max_tip_error` [m] is what it may err on held-out paths. While serving,
    the full model is asked every `check_period` [s] how far it would move the tip from where the reduced one
    has it: beyond `max_tip_error` health warns, and with `fall_back` the full model takes over, at
    `fall_back_rate` [Hz].
    """

    order: Literal["full", "reduced"] = "full"
    states: str | None = None
    max_tip_error: Positive = 1e-3
    check_period: Positive = 1.0
    fall_back: bool = False
    fall_back_rate: Annotated[float, Field(gt=0.0, le=10_000.0)] = 50.0


class ServiceSettings(Section):
    """The node.

    Hold after `target_timeout` without target, `late_limit` deadlines missed in a row or, in a closed loop,
    `measurement_timeout` without measurement; release within `release_time` at least [s]. A closed loop
    corrects targets with gain `feedback_gain` [1/s].
    """

    target_timeout: Positive = 0.5
    release_time: Positive = 1.0
    late_limit: Annotated[int, Field(ge=1)] = 25
    measurement_timeout: Positive = 0.25
    feedback_gain: Positive = 2.0


class RobotSettings(Section):
    """What every robot file says, whatever the robot is made of."""

    name: Name
    frame: Name = "base"
    gravity: Vector = (0.0, 0.0, -9.81)
    material: MaterialSettings
    fixed: Annotated[list[Box], Field(min_length=1)]
    cables: Annotated[list[CableSettings], Field(min_length=1)]
    effectors: Annotated[list[EffectorSettings], Field(min_length=1)]
    contacts: list[ContactSettings] = []
    contact: ContactRange = ContactRange()
    integration: IntegrationSettings = IntegrationSettings()
    controller: ControllerSettings = ControllerSettings()
    model: ModelSettings = ModelSettings()
    service: ServiceSettings = ServiceSettings()

    @model_validator(mode="after")
    def _names_once(self) -> Self:
        check_unique("cables", [cable.name for cable in self.cables])
        check_unique("effectors", [effector.name for effector in self.effectors])
        return self


class RobotConfig(RobotSettings):
    """The file of a robot made of tetrahedra."""

    mesh: MeshSettings
    surfaces: list[SurfaceSettings] = []

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


def check_surfaces(contacts: list[ContactSettings], known: set[str]) -> None:
    """Raise a ValueError when a contact names a surface that is not known."""
    for index, contact in enumerate(contacts):
        for name in (contact.candidates, contact.against):
            if name not in known:
                raise ValueError(
                    f"contacts.{index}: surface {name!r} is not defined, "
                    f"known are {', '.join(sorted(known)) or 'none'}"
                )


def read_toml(path: Path) -> dict[str, Any]:
    """What a TOML file says, not yet looked at.

    Raises:
        RobotFileError: missing, or not TOML.
    """
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise RobotFileError(f"{path}: cannot be read ({error})") from error
    except tomllib.TOMLDecodeError as error:
        raise RobotFileError(f"{path}: not TOML: {error}") from error


def validated(kind: type[S], raw: object, path: Path) -> S:
    """The contents of a file as a section of some kind.

    Raises:
        RobotFileError: a field that is not allowed; says which, what was found and what is allowed.
    """
    try:
        return kind.model_validate(raw)
    except ValidationError as error:
        first = error.errors()[0]
        field = ".".join(str(part) for part in first["loc"])
        text = repr(first["input"])
        shown = text if len(text) <= 100 else f"{text[:97]}..."
        found = "" if isinstance(first["input"], dict) else f", found {shown}"
        more = f" (and {error.error_count() - 1} more)" if error.error_count() > 1 else ""
        message = first["msg"].removeprefix("Value error, ")
        prefix = f"{field}: " if field else ""
        raise RobotFileError(f"{path}: {prefix}{message}{found}{more}") from error
