"""What a node says about the robot that it serves, checked."""

from __future__ import annotations

import base64
import binascii
from typing import Annotated

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from tauten.model import ActuatorKind
from tauten.model.numerics import Ints
from tauten.model.schema import EffectorKind, Name
from tauten.service.frames.effectors import EffectorLook, effector_looks
from tauten.service.frames.frame import ActuatorLook, RobotLook
from tauten.service.wire import NetworkError

_Limits = Annotated[tuple[float, float], Field()]
_Number = Annotated[float, Field(allow_inf_nan=False)]
_Acceleration = Annotated[float, Field(ge=-1e3, le=1e3, allow_inf_nan=False)]
_MOST = 10_000_000  # characters of a coded array
_Name = Annotated[Name, Field(max_length=100)]  # as robot files may have it


class _Described(BaseModel):
    """A part of the description; further entries are for others."""

    model_config = ConfigDict(frozen=True, extra="ignore")


class _Actuator(_Described):
    name: _Name
    kind: ActuatorKind
    tension: _Limits
    pull: _Limits
    flexibility: Annotated[float, Field(ge=0.0, allow_inf_nan=False)]


class _Effector(_Described):
    name: _Name
    kind: EffectorKind
    rest: Annotated[list[_Number], Field(max_length=7)]
    weight: Annotated[list[_Number], Field(max_length=6)]


class _Surface(_Described):
    vertices: Annotated[int, Field(ge=3)]
    triangles: Annotated[str, Field(max_length=_MOST)]
    segments: Annotated[str, Field(max_length=_MOST)]
    chambers: Annotated[str, Field(max_length=_MOST)]


class RobotDescription(_Described):
    """The description of a robot that is served."""

    robot: _Name
    frame: _Name
    rate: Annotated[float, Field(gt=0.0, le=1e5)]
    size: Annotated[float, Field(gt=0.0, le=1e3)]
    gravity: tuple[_Acceleration, _Acceleration, _Acceleration]
    target_timeout: Annotated[float, Field(gt=0.0)]
    actuators: Annotated[list[_Actuator], Field(max_length=1000)]
    effectors: Annotated[list[_Effector], Field(min_length=1, max_length=1000)]
    surface: _Surface

    def look(self) -> RobotLook:
        """The looks of the robot; its vertices are known with the first message.

        Raises:
            NetworkError: triangles, segments or chambers that do not fit.
        """
        surface = self.surface
        triangles = _numbers(self.robot, surface.triangles, surface.vertices)
        count = len(self.actuators)
        chambers = _numbers(self.robot, surface.chambers, count + 1) - 1
        if len(triangles) != 3 * len(chambers):
            raise NetworkError(f"the node of {self.robot!r}: its surface is damaged")
        return RobotLook(
            name=self.robot,
            frame=self.frame,
            rate=self.rate,
            size=self.size,
            vertices=np.zeros((surface.vertices, 3), np.float32),
            triangles=triangles.reshape(-1, 3),
            segment_owners=_numbers(self.robot, surface.segments, count),
            chamber_owners=chambers,
            actuators=tuple(
                ActuatorLook(one.name, one.kind, one.pull, one.tension, one.flexibility)
                for one in self.actuators
            ),
            effectors=self._effectors(),
            gravity=self.gravity,
        )

    def _effectors(self) -> tuple[EffectorLook, ...]:
        names = tuple(one.name for one in self.effectors)
        kinds = tuple(one.kind for one in self.effectors)
        try:
            return effector_looks(
                names,
                kinds,
                [tuple(one.rest) for one in self.effectors],
                [tuple(one.weight) for one in self.effectors],
            )
        except ValueError as error:
            raise NetworkError(f"the node of {self.robot!r}: {error}") from error


def read_description(robot: str, payload: bytes) -> RobotDescription:
    """The description in a node's answer.

    Args:
        robot: name, for messages.
        payload: JSON.

    Raises:
        NetworkError: no description, or that of a node of another version.
    """
    try:
        return RobotDescription.model_validate_json(payload)
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"])
        raise NetworkError(
            f"the node of {robot!r} describes itself otherwise than this version does ({place}: "
            f"{first['msg']}): start node and viewer from the same version"
        ) from error


def _numbers(robot: str, text: str, below: int) -> Ints:
    """Whole numbers below a bound, coded as `tauten.service.node` does it."""
    try:
        found = np.frombuffer(base64.b64decode(text, validate=True), "<u4").astype(np.int64)
    except (binascii.Error, ValueError) as error:
        raise NetworkError(f"the node of {robot!r}: its surface is damaged") from error
    if len(found) and found.max() >= below:
        raise NetworkError(
            f"the node of {robot!r}: its surface names point {found.max()} of {below}"
        )
    return found
