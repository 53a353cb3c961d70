"""Messages on the wire: ROS 2 messages in CDR, or the same fields as JSON.

| message | keys | fields |
|---|---|---|
| geometry_msgs/PointStamped | target, measurement, effector, plant/effector | point [m] in header.frame_id |
| geometry_msgs/PoseStamped | the same, of a frame | pose.position [m], pose.orientation |
| sensor_msgs/JointState | the same, of a distance, length or volume | position [m, m³] |
| sensor_msgs/JointState | actuation, plant/state | position = pull [m], effort = tension [N] |
| diagnostic_msgs/DiagnosticArray | health, plant/health | see `tauten.service.codec.health` |
| std_msgs/Float64 | plant/gap | smallest gap [m] |
| std_msgs/String | command | see `tauten.service.wire.commands` |
| tauten_msgs/Tick | tick | see `tauten.service.wire.tick` |
| nav_msgs/Odometry, geometry_msgs/WrenchStamped | obstacle_state, wrench | `tauten.service.wire.obstacles` |

Whatever arrives is checked: decoding returns the message or a `Rejection` and raises nothing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from tauten.service.codec.json_messages import (
    JSON_MODELS,
    NANO,
    SECONDS,
    JsonMessage,
    from_json,
)
from tauten.service.codec.rejection import Rejection, RejectionReason, quoted

POINT = "geometry_msgs/msg/PointStamped"
POSE = "geometry_msgs/msg/PoseStamped"
JOINTS = "sensor_msgs/msg/JointState"
HEALTH = "diagnostic_msgs/msg/DiagnosticArray"
FLOAT = "std_msgs/msg/Float64"
TEXT = "std_msgs/msg/String"
TICK = "tauten_msgs/msg/Tick"
CLOUD = "sensor_msgs/msg/PointCloud2"
ODOMETRY = "nav_msgs/msg/Odometry"
WRENCH = "geometry_msgs/msg/WrenchStamped"

TICK_DEFINITION = """\
std_msgs/Header header
uint64 tick
string mode
string cause
string status
geometry_msgs/Point[] goal
geometry_msgs/Point[] correction
builtin_interfaces/Time target_stamp
float64 lateness
float64 latency
float64 decide
float64 step
float64 slack
uint32 skipped
float64 deepest_gap
float64 complementarity
float64 stationarity
uint32 extra_columns
bool clamped
float64[] goal_values
float64[] correction_values
int32 checks
"""

CDR = "application/cdr"
JSON = "application/json"
# zenoh/bytes is the encoding of a publisher that names none
_CDR_ENCODINGS = frozenset({CDR, "zenoh/bytes", "application/octet-stream"})
MAX_PAYLOAD = 16_384  # bytes; the largest correct message but a cloud has a few hundred
LARGEST_CLOUD = 2**20  # bytes; Zenoh assembles no larger message here


@dataclass(frozen=True, slots=True)
class Joints:
    """sensor_msgs/JointState of cables: pulled lengths [m] and tensions [N]."""

    stamp: int
    frame: str
    names: tuple[str, ...]
    position: tuple[float, ...]
    effort: tuple[float, ...]


@cache
def typestore() -> Typestore:
    """Types of ROS 2 Humble, and `TICK`."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    store.max_sequence_length = MAX_PAYLOAD
    store.register(get_types_from_msg(TICK_DEFINITION, TICK))
    for kind in (POINT, POSE, JOINTS, HEALTH, FLOAT, TEXT, TICK, ODOMETRY, WRENCH):
        store.get_msgdef(kind)  # its code is generated now rather than in a loop
    return store


def definition(kind: str) -> str:
    """The ros2msg schema text of a message type, the types it uses included."""
    return str(typestore().generate_msgdef(kind, ros_version=2)[0])


def new(kind: str, **fields: object) -> Any:
    """A ROS message of a type."""
    return typestore().types[kind](**fields)  # type: ignore[arg-type]


def to_cdr(kind: str, message: object) -> bytes:
    """A ROS message in little-endian CDR."""
    return bytes(typestore().serialize_cdr(message, kind, little_endian=True))


def from_cdr(kind: str, payload: bytes, store: Typestore | None = None) -> Any | Rejection:
    """A ROS message of a type from CDR; without a store the types are those of `typestore`."""
    try:
        return (store or typestore()).deserialize_cdr(payload, kind)
    # bytes that anybody may send: whatever the library raises, the loop goes on
    except Exception as error:
        return Rejection(RejectionReason.MALFORMED, f"not a {kind} in CDR: {quoted(error)}")


def header(stamp: int, frame: str) -> Any:
    """std_msgs/Header of a time [ns since the epoch]."""
    return new("std_msgs/msg/Header", stamp=time_message(stamp), frame_id=frame)


def time_message(stamp: int) -> Any:
    """builtin_interfaces/Time of a time [ns since the epoch]."""
    return new("builtin_interfaces/msg/Time", sec=stamp // NANO, nanosec=stamp % NANO)


def nanoseconds(time: Any) -> int:
    """Nanoseconds since the epoch of a builtin_interfaces/Time."""
    return int(time.sec) * NANO + int(time.nanosec)


def encode_joints(joints: Joints) -> bytes:
    """Cables in CDR."""
    message = new(
        JOINTS,
        header=header(joints.stamp, joints.frame),
        name=list(joints.names),
        position=np.array(joints.position, dtype=np.float64),
        velocity=np.zeros(0),
        effort=np.array(joints.effort, dtype=np.float64),
    )
    return to_cdr(JOINTS, message)


def decode_joints(
    payload: bytes, encoding: str, names: tuple[str, ...] | None
) -> Joints | Rejection:
    """Cables from CDR, with finite numbers, or why the message was refused.

    They have these names in this order; None: any.
    """
    form = payload_format(payload, encoding, JOINTS)
    if isinstance(form, Rejection):
        return form
    if form == JSON:
        return Rejection(RejectionReason.ENCODING, "a JointState is read from CDR only")
    message = from_cdr(JOINTS, payload)
    if isinstance(message, Rejection):
        return message
    joints = Joints(
        nanoseconds(message.header.stamp),
        message.header.frame_id,
        tuple(message.name),
        tuple(map(float, message.position)),
        tuple(map(float, message.effort)),
    )
    expected = joints.names if names is None else names
    counts = {len(expected), len(joints.position), len(joints.effort)}
    if joints.names != expected or len(counts) > 1:
        detail = (
            f"found cables {quoted(', '.join(joints.names))} with {len(joints.position)} positions and "
            f"{len(joints.effort)} efforts, expected {', '.join(expected)}"
        )
        return Rejection(RejectionReason.WRONG_SHAPE, detail)
    if not all(map(math.isfinite, joints.position + joints.effort)):
        return Rejection(RejectionReason.NOT_FINITE, "a pull or tension is not finite")
    return joints


def encode_float(value: float) -> bytes:
    """A number in CDR."""
    return to_cdr(FLOAT, new(FLOAT, data=value))


def largest_of(kind: str) -> int:
    """Bytes that a message of a type has at most."""
    return LARGEST_CLOUD if kind == CLOUD else MAX_PAYLOAD


def payload_format(payload: bytes, encoding: str, kind: str) -> str | Rejection:
    """The format of a message of a type, `CDR` or `JSON`, or why it was refused.

    Its encoding is of Zenoh, such as "application/cdr;std_msgs/msg/Float64".
    """
    if len(payload) > largest_of(kind):
        return Rejection(
            RejectionReason.TOO_LARGE, f"{len(payload)} bytes, allowed are {largest_of(kind)}"
        )
    media, _, schema = encoding.partition(";")
    if schema and schema.replace("/msg/", "/") != kind.replace("/msg/", "/"):
        return Rejection(RejectionReason.WRONG_TYPE, f"found {quoted(schema)}, expected {kind}")
    if media in _CDR_ENCODINGS:
        return CDR
    if media == JSON:
        return JSON
    return Rejection(
        RejectionReason.ENCODING, f"found {quoted(encoding)}, allowed are {CDR} and {JSON}"
    )


def as_cdr(payload: bytes, encoding: str, kind: str) -> bytes | Rejection:
    """A message in CDR, as it is in logs: the same bytes, or the fields of one that is JSON."""
    form = payload_format(payload, encoding, kind)
    if form == CDR:
        return payload
    if isinstance(form, Rejection):
        return form
    if kind not in JSON_MODELS:
        return Rejection(RejectionReason.ENCODING, f"a {kind} is read from CDR only")
    found = from_json(kind, payload)
    return found if isinstance(found, Rejection) else to_cdr(kind, _ros_message(found))


def _ros_message(found: JsonMessage) -> Any:
    """The ROS message with the fields of one that was JSON."""
    fields = {name: getattr(found, name) for name in type(found).model_fields}
    for name, value in fields.items():
        if isinstance(value, JsonMessage):
            fields[name] = _ros_message(value)
        elif isinstance(value, tuple):
            fields[name] = list(value) if name == "name" else np.array(value, dtype=np.float64)
    return new(found.ros_type, **fields)


def time_of(time: Any) -> int | Rejection:
    """Nanoseconds since the epoch of a builtin_interfaces/Time that has arrived."""
    if not (0 <= time.sec < SECONDS and 0 <= time.nanosec < NANO):
        detail = f"stamp {time.sec} s {time.nanosec} ns is not a time"
        return Rejection(RejectionReason.MALFORMED, detail)
    return nanoseconds(time)
