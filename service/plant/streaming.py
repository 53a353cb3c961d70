"""Streams targets along a path to a robot's node."""

from __future__ import annotations

import logging
import time
from contextlib import ExitStack
from dataclasses import dataclass

import numpy as np
import zenoh

from tauten.service.node import Clock
from tauten.service.plant.waypoints import TargetPath
from tauten.service.process import StopFlag
from tauten.service.wire import (
    CDR,
    JSON,
    MESSAGE_TYPES,
    EffectorMessage,
    Keys,
    Network,
    RobotDescription,
    Role,
    check_node,
    effector_json,
    encode_effector,
    reach_of,
    session_of,
    wait_for,
)

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class StreamSettings:
    """Settings of a stream of targets.

    Attributes:
        rate: targets a second.
        duration: seconds; None: until the path ends, or a request to stop.
        json: as JSON rather than CDR.
        effector: number of the effector they are for.
        await_plant: whether to wait for a plant as well.
    """

    rate: float
    duration: float | None
    json: bool
    effector: int
    await_plant: bool


def stream(
    robot: RobotDescription,
    path: TargetPath,
    settings: StreamSettings,
    network: Network,
    stop: StopFlag,
) -> int:
    """Send targets, once the robot's node is alive; returns how many.

    Raises:
        NetworkError: no session, or the node serves another robot.
    """
    keys = Keys(robot.name)
    key = keys.targets(robot.effector_names)[settings.effector]
    with ExitStack() as stack:
        with stop.interruptible():
            opening = session_of(network, Role.OTHER, robot.name, connected=False)
            session = stack.enter_context(opening)
        tokens = [keys.token, *([keys.plant_token] if settings.await_plant else [])]
        if not all(wait_for(session, token, stop) for token in tokens):
            return 0
        check_node(session, robot)
        kind = robot.effectors[settings.effector].kind
        encoding = f"{JSON if settings.json else CDR};{MESSAGE_TYPES[kind]}"
        publisher = session.declare_publisher(key, encoding=encoding, express=True)
        return _send(publisher, robot, path, settings, stop)


def _send(
    publisher: zenoh.Publisher,
    robot: RobotDescription,
    path: TargetPath,
    settings: StreamSettings,
    stop: StopFlag,
) -> int:
    encode = effector_json if settings.json else encode_effector
    effector = robot.effectors[settings.effector]
    end = settings.duration
    if end is None and not path.repeats:
        end = path.duration
    _warn_of_distance(robot, path, settings.effector)
    log.info("sending targets to %s at %g Hz", robot.name, settings.rate)
    clock, count, elapsed, ended = Clock(1.0 / settings.rate), 0, 0.0, False
    while not stop.requested and not ended:
        # with the target at the end, also where that is between two ticks
        ended = end is not None and elapsed >= end
        values = tuple(path.at(elapsed if end is None else min(elapsed, end)).tolist())
        message = EffectorMessage(time.time_ns(), robot.frame, values)
        publisher.put(encode(effector.kind, effector.name, message))
        count += 1
        elapsed = clock.wait().index * clock.period
    log.info("%d targets sent", count)
    return count


def _warn_of_distance(robot: RobotDescription, path: TargetPath, number: int) -> None:
    """Log that a node refuses targets of a point or frame, as those that are in millimetres."""
    effector, reach = robot.effectors[number], reach_of(robot.size)
    if path.values.shape[1] == 1:
        return
    far = float(np.linalg.norm(path.values[:, :3] - effector.rest[:3], axis=1).max())
    if far > reach:
        log.warning(
            "targets are up to %.3g m from where %s is at rest; the node refuses those beyond %.3g m",
            far, effector.name, reach,
        )  # fmt: skip
