"""Targets, measurements and positions of effectors: one message type for each kind.

| kind | message | values |
|---|---|---|
| point, centre | geometry_msgs/PointStamped | point x, y, z [m] |
| frame | geometry_msgs/PoseStamped | position x, y, z [m], quaternion w, x, y, z |
| distance, length, volume | sensor_msgs/JointState | the one position [m, m³], named like the effector |

In messages and files a quaternion is x, y, z, w, as ROS has it; among goal values w is first.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from tauten.model import UNIT_LENGTH
from tauten.model.schema import EffectorKind
from tauten.service.wire.json_messages import (
    JsonJointState,
    JsonPointStamped,
    JsonPoseStamped,
    from_json,
)
from tauten.service.wire.messages import (
    JOINTS,
    JSON,
    POINT,
    POSE,
    Point,
    encode_point,
    from_cdr,
    header,
    header_json,
    new,
    payload_format,
    point_json,
    time_of,
    to_cdr,
)
from tauten.service.wire.rejection import Rejection, RejectionReason, quoted

MESSAGE_TYPES: dict[EffectorKind, str] = {
    "point": POINT, "centre": POINT, "frame": POSE, "distance": JOINTS, "length": JOINTS,
    "volume": JOINTS, "function": JOINTS,
}  # fmt: skip
_MODELS: dict[str, type[JsonPointStamped | JsonPoseStamped | JsonJointState]] = {
    POINT: JsonPointStamped, POSE: JsonPoseStamped, JOINTS: JsonJointState,
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class EffectorMessage:
    """Values of one effector: time [ns since the epoch], frame, goal values (v,) by its kind."""

    stamp: int
    frame: str
    values: tuple[float, ...]


def encode_effector(kind: EffectorKind, name: str, message: EffectorMessage) -> bytes:
    """Values of an effector in CDR.

    Args:
        kind: of the effector.
        name: of the effector.
        message: its values.
    """
    stamp, frame, values = message.stamp, message.frame, message.values
    if MESSAGE_TYPES[kind] == POINT:
        return encode_point(Point(stamp, frame, (values[0], values[1], values[2])))
    if kind == "frame":
        x, y, z, qw, qx, qy, qz = values
        pose = new(
            "geometry_msgs/msg/Pose",
            position=new("geometry_msgs/msg/Point", x=x, y=y, z=z),
            orientation=new("geometry_msgs/msg/Quaternion", x=qx, y=qy, z=qz, w=qw),
        )
        return to_cdr(POSE, new(POSE, header=header(stamp, frame), pose=pose))
    scalar = new(
        JOINTS,
        header=header(stamp, frame),
        name=[name],
        position=np.array(values, dtype=np.float64),
        velocity=np.zeros(0),
        effort=np.zeros(0),
    )
    return to_cdr(JOINTS, scalar)


def effector_json(kind: EffectorKind, name: str, message: EffectorMessage) -> bytes:
    """Values of an effector as JSON.

    Args:
        kind: of the effector.
        name: of the effector.
        message: its values.
    """
    stamp, frame, values = message.stamp, message.frame, message.values
    if MESSAGE_TYPES[kind] == POINT:
        return point_json(Point(stamp, frame, (values[0], values[1], values[2])))
    fields: dict[str, Any] = {"header": header_json(stamp, frame)}
    if kind == "frame":
        x, y, z, qw, qx, qy, qz = values
        orientation = {"x": qx, "y": qy, "z": qz, "w": qw}
        fields["pose"] = {"position": {"x": x, "y": y, "z": z}, "orientation": orientation}
    else:
        fields |= {"name": [name], "position": list(values)}
    return json.dumps(fields).encode()


def decode_effector(
    kind: EffectorKind, name: str, payload: bytes, encoding: str
) -> EffectorMessage | Rejection:
    """Values of an effector from CDR or JSON, finite, quaternions of length one.

    Args:
        kind: of the effector.
        name: of the effector.
        payload: the message.
        encoding: names the format and the type.

    Returns:
        The values, or why the message was refused.
    """
    expected = MESSAGE_TYPES[kind]
    form = payload_format(payload, encoding, expected)
    if isinstance(form, Rejection):
        if form.reason is RejectionReason.WRONG_TYPE:
            detail = f"{form.detail} for effector {name!r} of kind {kind!r}"
            return Rejection(RejectionReason.WRONG_TYPE, detail)
        return form
    read = _from_json if form == JSON else _from_cdr
    return _checked(read(kind, name, payload), kind)


def _from_cdr(kind: EffectorKind, name: str, payload: bytes) -> EffectorMessage | Rejection:
    message = from_cdr(MESSAGE_TYPES[kind], payload)
    if isinstance(message, Rejection):
        return message
    stamp, frame = time_of(message.header.stamp), str(message.header.frame_id)
    if isinstance(stamp, Rejection):
        return stamp
    if MESSAGE_TYPES[kind] == POINT:
        point = message.point
        return EffectorMessage(stamp, frame, (point.x, point.y, point.z))
    if MESSAGE_TYPES[kind] == JOINTS:
        positions = tuple(map(float, message.position))
        return _scalar(EffectorMessage(stamp, frame, positions), tuple(message.name), name)
    p, q = message.pose.position, message.pose.orientation
    return EffectorMessage(stamp, frame, (p.x, p.y, p.z, q.w, q.x, q.y, q.z))


def _from_json(kind: EffectorKind, name: str, payload: bytes) -> EffectorMessage | Rejection:
    expected = MESSAGE_TYPES[kind]
    found = from_json(_MODELS[expected], expected, payload)
    if isinstance(found, Rejection):
        other = _other_type(payload, expected)
        if not other:
            return found
        detail = f"found {other}, expected {expected} for effector {name!r} of kind {kind!r}"
        return Rejection(RejectionReason.WRONG_TYPE, detail)
    stamp, frame = found.header.nanoseconds, found.header.frame_id
    if isinstance(found, JsonPointStamped):
        return EffectorMessage(stamp, frame, (found.point.x, found.point.y, found.point.z))
    if isinstance(found, JsonJointState):
        return _scalar(EffectorMessage(stamp, frame, found.position), found.name, name)
    p, q = found.pose.position, found.pose.orientation
    return EffectorMessage(stamp, frame, (p.x, p.y, p.z, q.w, q.x, q.y, q.z))


def _other_type(payload: bytes, expected: str) -> str:
    """The type as which a message that is not of the expected one can be read; "" where there is none."""
    for kind, model in _MODELS.items():
        if kind != expected and not isinstance(from_json(model, kind, payload), Rejection):
            return kind
    return ""


def _scalar(
    message: EffectorMessage, names: tuple[str, ...], name: str
) -> EffectorMessage | Rejection:
    """A message of one position whose name, where it has one, is the effector's."""
    if len(message.values) != 1 or names not in ((), (name,)):
        shown = quoted(", ".join(names)) if names else "no name"
        detail = f"found {len(message.values)} positions of {shown}, expected one of {name!r}"
        return Rejection(RejectionReason.WRONG_SHAPE, detail)
    return message


def _checked(found: EffectorMessage | Rejection, kind: EffectorKind) -> EffectorMessage | Rejection:
    """A message with finite values and a quaternion of length one."""
    if isinstance(found, Rejection):
        return found
    if not all(map(math.isfinite, found.values)):
        return Rejection(RejectionReason.NOT_FINITE, f"{kind} {quoted(found.values)} is not finite")
    if kind != "frame":
        return found
    length = math.hypot(*found.values[3:])
    if not abs(length - 1.0) <= UNIT_LENGTH:
        detail = (
            f"the quaternion has length {length:.6g} and is no rotation, "
            f"allowed is 1 within {UNIT_LENGTH:g}"
        )
        return Rejection(RejectionReason.NO_ROTATION, detail)
    return found
