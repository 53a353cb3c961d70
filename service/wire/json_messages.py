"""The same messages as JSON: fields with the names of ROS 2, checked by pydantic; others are passed over.

Headers, their parts and the names of a JointState may be left out.
"""

from __future__ import annotations

from typing import Annotated, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from tauten.service.wire.rejection import Rejection, RejectionReason

NANO = 1_000_000_000
SECONDS = 2**31  # of a builtin_interfaces/Time
_MOST_TEXT = 200  # characters of a reason


class JsonMessage(BaseModel):
    """A message, or a part of one. Numbers are no text and no truth values."""

    model_config = ConfigDict(frozen=True, extra="ignore", strict=True)


class JsonTime(JsonMessage):
    """builtin_interfaces/Time."""

    sec: Annotated[int, Field(ge=0, lt=SECONDS)] = 0
    nanosec: Annotated[int, Field(ge=0, lt=NANO)] = 0


class JsonHeader(JsonMessage):
    """std_msgs/Header."""

    stamp: JsonTime = JsonTime()
    frame_id: str = ""


class JsonVector(JsonMessage):
    """geometry_msgs/Point."""

    x: float
    y: float
    z: float


class JsonQuaternion(JsonVector):
    """geometry_msgs/Quaternion."""

    w: float


class JsonPose(JsonMessage):
    """geometry_msgs/Pose."""

    position: JsonVector
    orientation: JsonQuaternion


class JsonPointStamped(JsonMessage):
    """geometry_msgs/PointStamped."""

    header: JsonHeader = JsonHeader()
    point: JsonVector


class JsonPoseStamped(JsonMessage):
    """geometry_msgs/PoseStamped."""

    header: JsonHeader = JsonHeader()
    pose: JsonPose


class JsonJointState(JsonMessage):
    """sensor_msgs/JointState."""

    header: JsonHeader = JsonHeader()
    name: tuple[str, ...] = ()
    position: tuple[float, ...]


class JsonText(JsonMessage):
    """std_msgs/String."""

    data: str


M = TypeVar("M", bound=JsonMessage)


def from_json(model: type[M], kind: str, payload: bytes) -> M | Rejection:
    """A message from JSON; its numbers may be infinite or NaN.

    Args:
        model: of the message.
        kind: message type, for the reason of a refusal.
        payload: the message.
    """
    try:
        return model.model_validate_json(payload)
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False)[0]
        place = ".".join(str(part) for part in first["loc"])
        detail = f"not a {kind} as JSON: {f'{place}: ' if place else ''}{first['msg']}"
        return Rejection(RejectionReason.MALFORMED, detail[:_MOST_TEXT])
