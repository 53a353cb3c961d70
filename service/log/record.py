"""A recorder outside the robot's processes: writes all messages on their keys into a log.

The node can record itself (`serve --record`). Its log has the robot file, and every tick also where the
network loses some. Replay such a log; a log of this recorder is for observation.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator
from itertools import chain
from pathlib import Path

import zenoh

from tauten.service.log.reader import description_metadata
from tauten.service.log.recorder import Entry, LogRecorder
from tauten.service.process import StopFlag
from tauten.service.wire import (
    CLOUD,
    FLOAT,
    HEALTH,
    JOINTS,
    MESSAGE_TYPES,
    ODOMETRY,
    TEXT,
    TICK,
    WRENCH,
    Keys,
    Rejection,
    Ring,
    as_cdr,
    ask_description,
    largest_of,
    payload_of,
    waiting,
)

log = logging.getLogger(__name__)

_RING = 4096
_PAUSE = 0.02  # s
_ANY = "*"  # name of an obstacle or a part


def message_kinds(keys: Keys, effectors: dict[str, str]) -> dict[str, str]:
    """Message type of each key of a robot; `effectors` are those of its effectors by name.

    The surface is left out: it is for viewers, and most of what goes over the wire.
    """
    groups = (keys.targets, keys.measurements, keys.effectors, keys.plant_effectors)
    names, types = tuple(effectors), tuple(effectors.values())
    pairs = [pair for group in groups for pair in zip(group(names), types, strict=True)]
    return {
        **dict(pairs),
        keys.command: TEXT,
        keys.actuation: JOINTS,
        keys.tick: TICK,
        keys.health: HEALTH,
        keys.contacts: CLOUD,
        keys.open_contacts: CLOUD,
        keys.wrench(_ANY): WRENCH,
        keys.obstacle(_ANY): MESSAGE_TYPES["frame"],
        keys.obstacle_state(_ANY): ODOMETRY,
        keys.plant_state: JOINTS,
        keys.plant_gap: FLOAT,
        keys.plant_health: HEALTH,
    }


def record_robot(session: zenoh.Session, robot: str, path: Path, stop: StopFlag) -> int:
    """Record a robot whose node is alive until `stop` is raised; returns the number of messages.

    Raises:
        NetworkError: a node that does not describe itself.
        OSError: the log cannot be created, or not be written to its end; it has what came before.
    """
    keys, count = Keys(robot), 0
    description = ask_description(session, keys)
    effectors = {one.name: MESSAGE_TYPES[one.kind] for one in description.effectors}
    kinds = message_kinds(keys, effectors)
    # one for each key: a node makes its surface while anybody subscribes to all keys
    sources = [session.declare_subscriber(key, zenoh.handlers.RingChannel(_RING)) for key in kinds]
    recorder = LogRecorder(path, description_metadata(description))
    log.info("recording %s to %s", robot, path)
    try:
        while not stop.requested and not recorder.fault:
            time.sleep(_PAUSE)
            news = chain.from_iterable(arrived(source, kinds, _RING) for source in sources)
            for key, kind, payload in news:
                seen = time.time_ns()
                recorder.write(Entry(key, kind, payload, seen, seen, 0))
                count += 1
    finally:
        recorder.close()
    if recorder.fault:
        raise OSError(recorder.fault)
    return count


def arrived(source: Ring, kinds: dict[str, str], most: int) -> Iterator[tuple[str, str, bytes]]:
    """Key, type and payload, in CDR, of messages that have arrived, not more than some.

    Those that are not of the type of their key are left out.
    """
    for sample in waiting(source, most):
        key = str(sample.key_expr)
        kind = kinds.get(key) or kinds.get(f"{key.rpartition('/')[0]}/{_ANY}")
        if kind is None:
            continue
        payload = payload_of(sample, largest_of(kind))
        if isinstance(payload, Rejection):
            continue
        message = as_cdr(payload, str(sample.encoding), kind)
        if not isinstance(message, Rejection):
            yield key, kind, message
