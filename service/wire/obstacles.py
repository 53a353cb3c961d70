"""Where obstacles are, and the wrenches on them and on the parts of a robot.

| message | keys | fields |
|---|---|---|
| geometry_msgs/PoseStamped | obstacle | where an obstacle is, see `tauten.service.wire.obstacle_subscriber` |
| nav_msgs/Odometry | obstacle_state | where the model has it; the twist is in its own frame |
| geometry_msgs/WrenchStamped | wrench | by contact on it, in the robot's frame and about its origin |
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model import UNIT_LENGTH
from tauten.model.contact import ObstaclePose, pose_at
from tauten.model.numerics import Array
from tauten.service.codec import (
    ODOMETRY,
    WRENCH,
    Rejection,
    RejectionReason,
    from_cdr,
    header,
    nanoseconds,
    new,
    quoted,
    to_cdr,
)


@dataclass(frozen=True, slots=True)
class ObstacleState:
    """Where the model has an obstacle: time [ns since the epoch], frame, its name and pose."""

    stamp: int
    frame: str
    name: str
    pose: ObstaclePose


def encode_obstacle(state: ObstacleState) -> bytes:
    """Where the model has an obstacle, in CDR."""
    pose, Q = state.pose, state.pose.Q
    w, x, y, z = pose.quaternion.tolist()
    where = new(
        "geometry_msgs/msg/Pose",
        position=_vector("Point", pose.position),
        orientation=new("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w),
    )
    twist = new(
        "geometry_msgs/msg/Twist",
        linear=_vector("Vector3", pose.velocity @ Q),
        angular=_vector("Vector3", pose.spin @ Q),
    )
    unknown = np.zeros(36)
    message = new(
        ODOMETRY,
        header=header(state.stamp, state.frame),
        child_frame_id=state.name,
        pose=new("geometry_msgs/msg/PoseWithCovariance", pose=where, covariance=unknown),
        twist=new("geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=unknown),
    )
    return to_cdr(ODOMETRY, message)


def decode_obstacle(payload: bytes) -> ObstacleState | Rejection:
    """Where the model of a node has an obstacle, from CDR: finite numbers, and a rotation."""
    message = from_cdr(ODOMETRY, payload)
    if isinstance(message, Rejection):
        return message
    pose, twist = message.pose.pose, message.twist.twist
    position, velocity, spin = (
        np.array([one.x, one.y, one.z]) for one in (pose.position, twist.linear, twist.angular)
    )
    turn = pose.orientation
    quaternion = np.array([turn.w, turn.x, turn.y, turn.z])
    if not np.isfinite(np.concatenate([position, velocity, spin, quaternion])).all():
        detail = f"the pose of {quoted(message.child_frame_id)} is not finite"
        return Rejection(RejectionReason.NOT_FINITE, detail)
    if abs(float(np.linalg.norm(quaternion)) - 1.0) > UNIT_LENGTH:
        detail = f"the quaternion of {quoted(message.child_frame_id)} is no rotation"
        return Rejection(RejectionReason.NO_ROTATION, detail)
    still = pose_at(position, quaternion)
    moving = pose_at(position, quaternion, still.Q @ velocity, still.Q @ spin)
    stamp, frame = nanoseconds(message.header.stamp), str(message.header.frame_id)
    return ObstacleState(stamp, frame, str(message.child_frame_id), moving)


def encode_wrench(stamp: int, frame: str, wrench: Array) -> bytes:
    """A wrench in CDR.

    Args:
        stamp: time [ns since the epoch].
        frame: of its vectors; the torque is about its origin.
        wrench: (6,) force [N] and torque [N m].
    """
    both = new(
        "geometry_msgs/msg/Wrench",
        force=_vector("Vector3", wrench[:3]),
        torque=_vector("Vector3", wrench[3:]),
    )
    return to_cdr(WRENCH, new(WRENCH, header=header(stamp, frame), wrench=both))


def decode_wrench(payload: bytes) -> Array | Rejection:
    """Force [N] and torque [N m] (6,) of a wrench from CDR, finite."""
    message = from_cdr(WRENCH, payload)
    if isinstance(message, Rejection):
        return message
    parts = (message.wrench.force, message.wrench.torque)
    found = np.array([value for one in parts for value in (one.x, one.y, one.z)])
    if not np.isfinite(found).all():
        return Rejection(RejectionReason.NOT_FINITE, "a wrench is not finite")
    return found


def _vector(kind: str, values: Array) -> object:
    x, y, z = values.tolist()
    return new(f"geometry_msgs/msg/{kind}", x=x, y=y, z=z)
