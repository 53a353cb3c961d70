"""Streams targets along a path to a robot's node."""

from __future__ import annotations

import logging
import time
from dataclasses import dataclass

import zenoh

from tauten.service.node import Clock
from tauten.service.plant.paths import TargetPath
from tauten.service.plant.receiver import Receiver
from tauten.service.process import StopFlag
from tauten.service.wire import (
    CDR,
    JSON,
    POINT,
    Keys,
    Network,
    Point,
    Role,
    encode_point,
    open_session,
    point_json,
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
    receiver: Receiver, path: TargetPath, settings: StreamSettings, network: Network, stop: StopFlag
) -> int:
    """Send targets, once the robot's node is alive; returns how many.

    Args:
        receiver: the robot that is served.
        path: of the targets.
        settings: of the stream.
        network: ports or configuration.
        stop: ends the stream.

    Raises:
        NetworkError: no session.
    """
    keys = Keys(receiver.name)
    key = keys.targets(receiver.effectors)[settings.effector]
    session = open_session(network, Role.OTHER, receiver.name)
    try:
        tokens = [keys.token, *([keys.plant_token] if settings.await_plant else [])]
        if not all(wait_for(session, token, stop) for token in tokens):
            return 0
        encoding = f"{JSON if settings.json else CDR};{POINT}"
        publisher = session.declare_publisher(key, encoding=encoding, express=True)
        return _send(publisher, receiver.frame, path, settings, stop)
    finally:
        session.close()  # type: ignore[no-untyped-call]


def _send(
    publisher: zenoh.Publisher,
    frame: str,
    path: TargetPath,
    settings: StreamSettings,
    stop: StopFlag,
) -> int:
    encode = point_json if settings.json else encode_point
    end = settings.duration
    if end is None and not path.repeats:
        end = path.duration
    clock, count, elapsed = Clock(1.0 / settings.rate), 0, 0.0
    while not stop.requested and (end is None or elapsed <= end):
        x, y, z = path.at(elapsed).tolist()
        publisher.put(encode(Point(time.time_ns(), frame, (x, y, z))))
        count += 1
        elapsed = clock.wait().index * clock.period
    log.info("%d targets sent", count)
    return count
