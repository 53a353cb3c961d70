"""What a plant publishes, written into the node's log beside the node's own messages."""

from __future__ import annotations

import time

import zenoh

from tauten.model import Robot
from tauten.service.log import Entry, LogRecorder
from tauten.service.wire import CDR, FLOAT, HEALTH, JOINTS, POINT, Keys, Rejection, payload_format

_RING = 256


class PlantRecorder:
    """Copies a plant's messages into a log."""

    def __init__(self, session: zenoh.Session, robot: Robot, recorder: LogRecorder) -> None:
        """Listen to the plants of a robot."""
        keys = Keys(robot.name)
        self._kinds = {
            keys.plant_state: JOINTS,
            keys.plant_gap: FLOAT,
            keys.plant_health: HEALTH,
            **dict.fromkeys(keys.plant_effectors(robot.effector_names), POINT),
        }
        self._recorder = recorder
        self._source = session.declare_subscriber(keys.plant, zenoh.handlers.RingChannel(_RING))

    def drain(self, tick: int) -> None:
        """Write what has arrived; what is not a plant's message is left out."""
        for _ in range(_RING):
            sample = self._source.try_recv()
            if sample is None:
                return
            key, payload = str(sample.key_expr), bytes(sample.payload)
            kind = self._kinds.get(key)
            if kind is None:
                continue
            found = payload_format(payload, str(sample.encoding), kind)
            if isinstance(found, Rejection) or found != CDR:
                continue
            seen = time.time_ns()
            self._recorder.write(Entry(key, kind, payload, False, seen, seen, tick))
