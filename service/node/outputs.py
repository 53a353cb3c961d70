"""Messages that leave a node each tick, and their copies in its log.

Actuation always leaves. The model's effectors and the tick are encoded only when there is a subscriber or a
log: at a kilohertz their encoding is a twentieth of the period.
"""

from __future__ import annotations

import zenoh

from tauten.model import Robot
from tauten.service.log import Entry, LogRecorder
from tauten.service.node.loop import Action
from tauten.service.wire import (
    HEALTH,
    JOINTS,
    POINT,
    TICK,
    Joints,
    Keys,
    Mode,
    Point,
    Publisher,
    Tick,
    encode_joints,
    encode_point,
    encode_tick,
)


class NodeOutputs:
    """Publishes what a node sends."""

    def __init__(self, session: zenoh.Session, robot: Robot, recorder: LogRecorder | None) -> None:
        """Declare the publishers.

        Args:
            session: open Zenoh session.
            robot: that is served.
            recorder: of the log; None: none is kept.
        """
        keys = Keys(robot.name)
        self._robot = robot
        self._recorder = recorder
        self._actuation = Publisher(session, keys.actuation, JOINTS)
        self._effectors = [
            Publisher(session, key, POINT, urgent=False)
            for key in keys.effectors(robot.effector_names)
        ]
        self._tick = Publisher(session, keys.tick, TICK, urgent=False)
        self._health = Publisher(session, keys.health, HEALTH, urgent=False)

    def actuate(self, action: Action, stamp: int, tick: int) -> None:
        """Publish actuation, then the model's effectors after the tick.

        Args:
            action: of the tick.
            stamp: time [ns since the epoch].
            tick: its number.
        """
        robot, actuation = self._robot, action.actuation
        joints = Joints(
            stamp, robot.frame, robot.actuators.names,
            tuple(actuation.pull.tolist()), tuple(actuation.tension.tolist()),
        )  # fmt: skip
        self._send(self._actuation, encode_joints(joints), stamp, tick)
        if action.mode is Mode.STOP:  # the model does not follow a release
            return
        for publisher, position in zip(self._effectors, actuation.effector, strict=True):
            if self._is_used(publisher):
                x, y, z = position.tolist()
                payload = encode_point(Point(stamp, robot.frame, (x, y, z)))
                self._send(publisher, payload, stamp, tick)

    def tick(self, tick: Tick) -> None:
        """Publish a tick."""
        if self._is_used(self._tick):
            self._send(self._tick, encode_tick(tick), tick.stamp, tick.index)

    def health(self, payload: bytes, stamp: int, tick: int) -> None:
        """Publish encoded health.

        Args:
            payload: the message.
            stamp: time [ns since the epoch].
            tick: number of the tick.
        """
        self._send(self._health, payload, stamp, tick)

    def _is_used(self, publisher: Publisher) -> bool:
        return self._recorder is not None or publisher.has_subscribers

    def _send(self, publisher: Publisher, payload: bytes, stamp: int, tick: int) -> None:
        publisher.put(payload)
        if self._recorder is not None:
            entry = Entry(publisher.key, publisher.kind, payload, False, stamp, stamp, tick)
            self._recorder.write(entry)
