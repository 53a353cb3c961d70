"""The same messages as JSON: fields with the names of ROS 2, checked by pydantic; others are passed over.

Headers, their parts and the names of a JointState may be left out. Arrays of descriptions are base64.
"""

from __future__ import annotations

import base64
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError
from pydantic_core import core_schema

from tauten.service.codec.rejection import Rejection, RejectionReason

if TYPE_CHECKING:
    from numpy.typing import NDArray

NANO = 1_000_000_000
SECONDS = 2**31  # of a builtin_interfaces/Time
_MOST_TEXT = 200  # characters of a reason
_MOST = 10_000_000  # characters of a coded array
FARTHEST = 1e6  # m, of a point of a description


class JsonMessage(BaseModel):
    """A message, or a part of one, and its ROS type. Numbers are no text and no truth values."""

    model_config = ConfigDict(frozen=True, extra="ignore", strict=True)
    ros_type: ClassVar[str]


class _Time(JsonMessage):
    ros_type = "builtin_interfaces/msg/Time"
    sec: Annotated[int, Field(ge=0, lt=SECONDS)] = 0
    nanosec: Annotated[int, Field(ge=0, lt=NANO)] = 0


class _Header(JsonMessage):
    ros_type = "std_msgs/msg/Header"
    stamp: _Time = _Time()
    frame_id: str = ""


class _Vector(JsonMessage):
    ros_type = "geometry_msgs/msg/Point"
    x: float
    y: float
    z: float


class _Quaternion(_Vector):
    ros_type = "geometry_msgs/msg/Quaternion"
    w: float


class _Pose(JsonMessage):
    ros_type = "geometry_msgs/msg/Pose"
    position: _Vector
    orientation: _Quaternion


class _PointStamped(JsonMessage):
    ros_type = "geometry_msgs/msg/PointStamped"
    header: _Header = _Header()
    point: _Vector


class _PoseStamped(JsonMessage):
    ros_type = "geometry_msgs/msg/PoseStamped"
    header: _Header = _Header()
    pose: _Pose


class _JointState(JsonMessage):
    ros_type = "sensor_msgs/msg/JointState"
    header: _Header = _Header()
    name: tuple[str, ...] = ()
    position: tuple[float, ...]
    velocity: tuple[float, ...] = ()
    effort: tuple[float, ...] = ()


class _Text(JsonMessage):
    ros_type = "std_msgs/msg/String"
    data: str


# messages that may be JSON
JSON_MODELS: dict[str, type[JsonMessage]] = {
    model.ros_type: model for model in (_PointStamped, _PoseStamped, _JointState, _Text)
}


def from_json(kind: str, payload: bytes) -> JsonMessage | Rejection:
    """A message of one of these types from JSON; its numbers may be infinite or NaN."""
    try:
        return JSON_MODELS[kind].model_validate_json(payload)
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False)[0]
        place = ".".join(str(part) for part in first["loc"])
        detail = f"not a {kind} as JSON: {f'{place}: ' if place else ''}{first['msg']}"
        return Rejection(RejectionReason.MALFORMED, detail[:_MOST_TEXT])


def _coded(text: object, kind: str) -> NDArray[Any]:
    """The numbers of a numpy type that a text in base64 has; a ValueError where it is none."""
    if not isinstance(text, str) or len(text) > _MOST:
        raise ValueError("not numbers in base64")
    return np.frombuffer(base64.b64decode(text, validate=True), kind)


@dataclass(frozen=True, slots=True)
class CodedNumbers:
    """Whole numbers as little-endian uint32 in base64: triangles would be most of the text otherwise.

    Attributes:
        first: number that is coded as zero.
        columns: of a table of numbers; 0: one row.
    """

    first: int = 0
    columns: int = 0

    def read(self, text: object) -> object:
        """The numbers of a text; arrays stay as they are."""
        if isinstance(text, np.ndarray):
            return text
        found = self.first + _coded(text, "<u4").astype(np.int64)
        return found.reshape(-1, self.columns) if self.columns else found

    def text(self, numbers: NDArray[Any]) -> str:
        """The text of numbers."""
        return base64.b64encode((numbers - self.first).astype("<u4").tobytes()).decode("ascii")

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        """How a field of this annotation is read and written."""
        return core_schema.no_info_plain_validator_function(
            self.read,
            serialization=core_schema.plain_serializer_function_ser_schema(self.text),
        )


class CodedPoints(CodedNumbers):
    """Points (m, 3) as little-endian float32 in base64."""

    def read(self, text: object) -> object:
        """The points of a text; arrays stay as they are."""
        if isinstance(text, np.ndarray):
            return text
        points = _coded(text, "<f4").astype(float).reshape(-1, 3)
        if not (np.abs(points) <= FARTHEST).all():  # also NaN
            raise ValueError("a point is not finite, or farther than it may be")
        return points

    def text(self, points: NDArray[Any]) -> str:
        """The text of points."""
        return base64.b64encode(points.astype("<f4").tobytes()).decode("ascii")
