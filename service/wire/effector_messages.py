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

from tauten.model import UNIT_LENGTH
from tauten.model.schema import EffectorKind
from tauten.service.codec import (
    JOINTS,
    JSON,
    JSON_MODELS,
    NANO,
    POINT,
    POSE,
    Joints,
    Rejection,
    RejectionReason,
    encode_joints,
    from_cdr,
    from_json,
    header,
    new,
    payload_format,
    quoted,
    time_of,
    to_cdr,
)

MESSAGE_TYPES: dict[EffectorKind, str] = {
    "point": POINT, "centre": POINT, "frame": POSE, "distance": JOINTS, "length": JOINTS,
    "volume": JOINTS, "function": JOINTS,
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class EffectorMessage:
    """Values of one effector: time [ns since the epoch], frame, goal values (v,) by its kind."""

    stamp: int
    frame: str
    values: tuple[float, ...]


def encode_effector(kind: EffectorKind, name: str, message: EffectorMessage) -> bytes:
    """Values of an effector in CDR."""
    stamp, frame, values = message.stamp, message.frame, message.values
    if MESSAGE_TYPES[kind] == JOINTS:
        return encode_joints(Joints(stamp, frame, (name,), values, ()))
    x, y, z = values[:3]
    position = new("geometry_msgs/msg/Point", x=x, y=y, z=z)
    if kind != "frame":
        return to_cdr(POINT, new(POINT, header=header(stamp, frame), point=position))
    qw, qx, qy, qz = values[3:]
    orientation = new("geometry_msgs/msg/Quaternion", x=qx, y=qy, z=qz, w=qw)
    pose = new("geometry_msgs/msg/Pose", position=position, orientation=orientation)
    return to_cdr(POSE, new(POSE, header=header(stamp, frame), pose=pose))


def effector_json(kind: EffectorKind, name: str, message: EffectorMessage) -> bytes:
    """Values of an effector as JSON."""
    sec, nanosec = divmod(message.stamp, NANO)
    header = {"stamp": {"sec": sec, "nanosec": nanosec}, "frame_id": message.frame}
    fields: dict[str, Any] = {"name": [name], "position": message.values}
    if MESSAGE_TYPES[kind] != JOINTS:
        x, y, z, *rotation = message.values
        fields = {"point": {"x": x, "y": y, "z": z}}
    if kind == "frame":
        qw, qx, qy, qz = rotation
        orientation = {"x": qx, "y": qy, "z": qz, "w": qw}
        fields = {"pose": {"position": fields["point"], "orientation": orientation}}
    return json.dumps({"header": header, **fields}).encode()


def decode_effector(
    kind: EffectorKind, name: str, payload: bytes, encoding: str
) -> EffectorMessage | Rejection:
    """Values of an effector from CDR or JSON, finite, quaternions of length one, or why they were refused."""
    expected = MESSAGE_TYPES[kind]
    form = payload_format(payload, encoding, expected)
    if isinstance(form, Rejection):
        if form.reason is RejectionReason.WRONG_TYPE:
            detail = f"{form.detail} for effector {name!r} of kind {kind!r}"
            return Rejection(RejectionReason.WRONG_TYPE, detail)
        return form
    read = from_json if form == JSON else from_cdr
    found: Any = read(expected, payload)
    if isinstance(found, Rejection):
        other = _other_type(payload, expected) if form == JSON else ""
        if not other:
            return found
        detail = f"found {other}, expected {expected} for effector {name!r} of kind {kind!r}"
        return Rejection(RejectionReason.WRONG_TYPE, detail)
    stamp, frame = time_of(found.header.stamp), str(found.header.frame_id)
    if isinstance(stamp, Rejection):
        return stamp
    if expected == JOINTS:
        message = EffectorMessage(stamp, frame, tuple(map(float, found.position)))
        return _scalar(message, tuple(found.name), name, kind)
    if kind != "frame":
        point = found.point
        return _checked(EffectorMessage(stamp, frame, (point.x, point.y, point.z)), kind)
    p, q = found.pose.position, found.pose.orientation
    return _checked(EffectorMessage(stamp, frame, (p.x, p.y, p.z, q.w, q.x, q.y, q.z)), kind)


def _other_type(payload: bytes, expected: str) -> str:
    """The type as which a message that is not of the expected one can be read; "" where there is none."""
    for kind in JSON_MODELS:
        if kind != expected and not isinstance(from_json(kind, payload), Rejection):
            return kind
    return ""


def _scalar(
    message: EffectorMessage, names: tuple[str, ...], name: str, kind: EffectorKind
) -> EffectorMessage | Rejection:
    """A message of one position whose name, where it has one, is the effector's."""
    if len(message.values) != 1 or names not in ((), (name,)):
        shown = quoted(", ".join(names)) if names else "no name"
        detail = f"found {len(message.values)} positions of {shown}, expected one of {name!r}"
        return Rejection(RejectionReason.WRONG_SHAPE, detail)
    return _checked(message, kind)


def _checked(found: EffectorMessage, kind: EffectorKind) -> EffectorMessage | Rejection:
    """A message with finite values and a quaternion of length one."""
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
