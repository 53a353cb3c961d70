"""What a node publishes each tick, and writes into its log.

Actuation always leaves. Where the model is and what the tick was are put into messages only when somebody
listens or a log is kept: at a kilohertz their encoding is a twentieth of the period.
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
    """A node's outlets."""

    def __init__(self, session: zenoh.Session, robot: Robot, recorder: LogRecorder | None) -> None:
        """Declare the publishers.

        Args:
            session: open Zenoh session.
            robot: whose they are.
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

    def act(self, action: Action, stamp: int, tick: int) -> None:
        """Actuation first, then where the model's effectors will be."""
        robot = self._robot
        joints = Joints(
            stamp, robot.frame, robot.cable_names,
            tuple(action.pull.tolist()), tuple(action.tension.tolist()),
        )  # fmt: skip
        self._send(self._actuation, encode_joints(joints), stamp, tick)
        if action.mode is Mode.STOP:  # the model does not follow a release
            return
        for outlet, position in zip(self._effectors, action.effector, strict=True):
            if self._wanted(outlet):
                x, y, z = position.tolist()
                self._send(outlet, encode_point(Point(stamp, robot.frame, (x, y, z))), stamp, tick)

    def tick(self, tick: Tick) -> None:
        """What the tick was."""
        if self._wanted(self._tick):
            self._send(self._tick, encode_tick(tick), tick.stamp, tick.index)

    def health(self, payload: bytes, stamp: int, tick: int) -> None:
        """How the node is, encoded."""
        self._send(self._health, payload, stamp, tick)

    def _wanted(self, outlet: Publisher) -> bool:
        return self._recorder is not None or outlet.heard

    def _send(self, outlet: Publisher, payload: bytes, stamp: int, tick: int) -> None:
        outlet.put(payload)
        if self._recorder is not None:
            self._recorder.write(Entry(outlet.key, outlet.kind, payload, False, stamp, stamp, tick))
