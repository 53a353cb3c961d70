"""What a node says about the robot that it serves, checked before anything of it is used."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from tauten.model import ROWS, VALUES, ActuatorKind
from tauten.model.schema import EffectorKind, Name
from tauten.service.link import NetworkError

_Limits = tuple[float, float]
_Number = Annotated[float, Field(allow_inf_nan=False)]
_Acceleration = Annotated[float, Field(ge=-1e3, le=1e3, allow_inf_nan=False)]
_Name = Annotated[Name, Field(max_length=100)]  # as robot files may have it
_Text = Annotated[str, Field(max_length=200)]
_MOST = 10_000_000  # characters of a coded array


class _Described(BaseModel):
    """A part of the description; further entries are for others."""

    model_config = ConfigDict(frozen=True, extra="ignore")


class DescribedActuator(_Described):
    """An actuator: limits of its position `position` and of its effort `effort` [SI]."""

    name: _Name
    kind: ActuatorKind
    effort: _Limits
    position: _Limits
    flexibility: Annotated[float, Field(ge=0.0, allow_inf_nan=False)]


class DescribedEffector(_Described):
    """An effector, its goal values at rest, and the weights of its rows."""

    name: _Name
    kind: EffectorKind
    rest: Annotated[tuple[_Number, ...], Field(max_length=7)]
    weight: Annotated[tuple[_Number, ...], Field(max_length=6)]

    @model_validator(mode="after")
    def _has_its_values(self) -> Self:
        if len(self.rest) != VALUES[self.kind]:
            raise ValueError(
                f"a {self.kind} has {VALUES[self.kind]} values, found {len(self.rest)}"
            )
        if len(self.weight) != ROWS[self.kind]:
            found = len(self.weight)
            raise ValueError(f"a {self.kind} has {ROWS[self.kind]} weights, found {found}")
        return self


class DescribedSurface(_Described):
    """The skin: number of its vertices, and coded arrays."""

    vertices: Annotated[int, Field(ge=3)]
    triangles: Annotated[str, Field(max_length=_MOST)]
    segments: Annotated[str, Field(max_length=_MOST)]
    chambers: Annotated[str, Field(max_length=_MOST)]


class DescribedModel(_Described):
    """The model that decides."""

    digest: _Text


class DescribedBasis(_Described):
    """The contact basis."""

    name: _Text
    digest: _Text


class RobotDescription(_Described):
    """The description of a robot that is served."""

    robot: _Name
    frame: _Name
    rate: Annotated[float, Field(gt=0.0, le=1e5)]
    size: Annotated[float, Field(gt=0.0, le=1e3)]
    gravity: tuple[_Acceleration, _Acceleration, _Acceleration]
    target_timeout: Annotated[float, Field(gt=0.0)]
    actuators: Annotated[tuple[DescribedActuator, ...], Field(max_length=1000)]
    effectors: Annotated[tuple[DescribedEffector, ...], Field(min_length=1, max_length=1000)]
    surface: DescribedSurface
    model: DescribedModel
    basis: DescribedBasis
    versions: dict[_Text, _Text]


def read_description(robot: str, payload: bytes) -> RobotDescription:
    """The description in a node's answer.

    Args:
        robot: name.
        payload: JSON.

    Raises:
        NetworkError: no description, that of another robot, or that of a node of another version.
    """
    try:
        found = RobotDescription.model_validate_json(payload)
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False, include_input=False)[0]
        place = ".".join(
            str(part) for part in first["loc"] if isinstance(part, int) or part in _PARTS
        )
        place = f"{place}: " if place else ""
        raise NetworkError(
            f"the node of {robot!r} describes itself otherwise than this version does ({place}"
            f"{first['msg']}): start node and this command from the same version"
        ) from error
    if found.robot != robot:
        raise NetworkError(f"the node of {robot!r} describes another robot, {found.robot!r}")
    return found


_PARTS = frozenset(
    name
    for model in (
        RobotDescription, DescribedActuator, DescribedEffector, DescribedSurface, DescribedModel,
        DescribedBasis,
    )
    for name in model.model_fields
)  # fmt: skip
