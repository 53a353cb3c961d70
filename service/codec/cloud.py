"""Points with numbers beside them, as sensor_msgs/PointCloud2 of 32-bit floats.

A node publishes its skin and its contacts in this form. They are far larger than other messages, so that
they have a limit of their own, and only viewers decode them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore

from tauten.service.codec.messages import (
    CLOUD,
    LARGEST_CLOUD,
    from_cdr,
    header,
    nanoseconds,
    new,
    to_cdr,
)
from tauten.service.codec.rejection import Rejection, RejectionReason

if TYPE_CHECKING:
    from tauten.model import ContactForces

SKIN_FIELDS = ("x", "y", "z")
# Point, force on the robot, normal towards it, gap, number of the pair, whether it slides, margin to slip.
CONTACT_FIELDS = (
    "x", "y", "z", "fx", "fy", "fz", "nx", "ny", "nz", "gap", "pair", "sliding", "margin",
)  # fmt: skip
_FIELD = "sensor_msgs/msg/PointField"
_FLOAT32 = 7  # datatype of PointField


@dataclass(frozen=True, slots=True)
class Cloud:
    """Points: time [ns since the epoch], frame, and (m, k) numbers, k fields a point."""

    stamp: int
    frame: str
    values: NDArray[np.float32]


def contact_cloud(stamp: int, frame: str, found: ContactForces, pushing: bool = True) -> Cloud:
    """The contacts in range that push, or those that do not, with the columns `CONTACT_FIELDS`."""
    chosen, contacts = np.flatnonzero(found.pushing == pushing), found.contacts
    columns = (
        contacts.gap, contacts.pair.astype(float), found.sliding.astype(float), found.margin,
    )  # fmt: skip
    vectors = (contacts.point, found.force, contacts.normal)
    values = np.hstack([*vectors, *(one[:, None] for one in columns)])[chosen]
    return Cloud(stamp, frame, values)


def encode_cloud(cloud: Cloud, fields: tuple[str, ...]) -> bytes:
    """A cloud in CDR; `fields` name its k columns."""
    values = np.ascontiguousarray(cloud.values, dtype="<f4")
    count, width = values.shape
    message = new(
        CLOUD,
        header=header(cloud.stamp, cloud.frame),
        height=1,
        width=count,
        fields=[
            new(_FIELD, name=name, offset=4 * i, datatype=_FLOAT32, count=1)
            for i, name in enumerate(fields)
        ],
        is_bigendian=False,
        point_step=4 * width,
        row_step=4 * width * count,
        data=values.view(np.uint8).reshape(-1),
        is_dense=True,
    )
    return to_cdr(CLOUD, message)


def decode_cloud(payload: bytes, fields: tuple[str, ...]) -> Cloud | Rejection:
    """A cloud of finite numbers from CDR, whose columns have these fields, or why the message was refused."""
    if len(payload) > LARGEST_CLOUD:
        detail = f"{len(payload)} bytes, allowed are {LARGEST_CLOUD}"
        return Rejection(RejectionReason.TOO_LARGE, detail)
    message = from_cdr(CLOUD, payload, _large())
    if isinstance(message, Rejection):
        return message
    found = tuple((one.name, one.offset, one.datatype, one.count) for one in message.fields)
    expected = tuple((name, 4 * i, _FLOAT32, 1) for i, name in enumerate(fields))
    size = 4 * len(fields) * message.width
    if found != expected or message.height != 1 or len(message.data) != size:
        return Rejection(RejectionReason.WRONG_SHAPE, f"not points with the fields {fields}")
    values = np.frombuffer(message.data.tobytes(), "<f4").reshape(-1, len(fields))
    if not np.isfinite(values).all():
        return Rejection(RejectionReason.NOT_FINITE, "a point is not finite")
    return Cloud(nanoseconds(message.header.stamp), message.header.frame_id, values)


@cache
def _large() -> Typestore:
    """Types of ROS 2 Humble with long sequences."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    store.max_sequence_length = LARGEST_CLOUD
    return store
