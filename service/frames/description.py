"""The looks of a robot that a node serves, from its description."""

from __future__ import annotations

import base64
import binascii

import numpy as np

from tauten.model.numerics import Ints
from tauten.service.frames.effectors import effector_looks
from tauten.service.frames.frame import ActuatorLook, RobotLook
from tauten.service.wire import NetworkError, RobotDescription


def described_look(description: RobotDescription) -> RobotLook:
    """The looks of a robot; its vertices are known with the first message.

    Raises:
        NetworkError: triangles, segments or chambers that do not fit.
    """
    robot, surface = description.robot, description.surface
    triangles = _numbers(robot, surface.triangles, surface.vertices)
    count = len(description.actuators)
    chambers = _numbers(robot, surface.chambers, count + 1) - 1
    if len(triangles) != 3 * len(chambers):
        raise NetworkError(f"the node of {robot!r}: its surface is damaged")
    names = tuple(one.name for one in description.effectors)
    kinds = tuple(one.kind for one in description.effectors)
    return RobotLook(
        name=robot,
        frame=description.frame,
        rate=description.rate,
        size=description.size,
        vertices=np.zeros((surface.vertices, 3), np.float32),
        triangles=triangles.reshape(-1, 3),
        segment_owners=_numbers(robot, surface.segments, count),
        chamber_owners=chambers,
        actuators=tuple(
            ActuatorLook(one.name, one.kind, one.position, one.effort, one.flexibility)
            for one in description.actuators
        ),
        effectors=effector_looks(
            names,
            kinds,
            [one.rest for one in description.effectors],
            [one.weight for one in description.effectors],
        ),
        gravity=description.gravity,
    )


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
