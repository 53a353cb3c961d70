"""What a node publishes each tick, and writes into its log."""

from __future__ import annotations

import zenoh

from tauten.model import Robot
from tauten.service.health import Diagnostic, encode_health
from tauten.service.keys import Keys
from tauten.service.loop import Action
from tauten.service.messages import (
    HEALTH,
    JOINTS,
    POINT,
    TICK,
    Joints,
    Point,
    encode_joints,
    encode_point,
)
from tauten.service.outlet import Outlet
from tauten.service.record import Entry, Recorder
from tauten.service.state_machine import Mode
from tauten.service.tick import Tick, encode_tick


class Publishing:
    """A node's outlets."""

    def __init__(self, session: zenoh.Session, robot: Robot, recorder: Recorder | None) -> None:
        """Declare the publishers.

        Args:
            session: open Zenoh session.
            robot: whose they are.
            recorder: of the log; None: none is kept.
        """
        keys = Keys(robot.name)
        self._robot = robot
        self._recorder = recorder
        self._actuation = Outlet(session, keys.actuation, JOINTS)
        self._effectors = [
            Outlet(session, key, POINT, urgent=False)
            for key in keys.effectors(robot.effector_names)
        ]
        self._tick = Outlet(session, keys.tick, TICK, urgent=False)
        self._health = Outlet(session, keys.health, HEALTH, urgent=False)

    def act(self, action: Action, stamp: int, tick: int) -> None:
        """Actuation first, then where the model's effectors will be."""
        robot = self._robot
        joints = Joints(
            stamp, robot.frame, robot.cable_names,
            tuple(action.pull.tolist()), tuple(action.tension.tolist()),
        )  # fmt: skip
        self._send(self._actuation, encode_joints(joints), stamp, tick)
        if action.mode is not Mode.STOP:  # the model does not follow a release
            for outlet, (x, y, z) in zip(self._effectors, action.effector.tolist(), strict=True):
                self._send(outlet, encode_point(Point(stamp, robot.frame, (x, y, z))), stamp, tick)

    def tick(self, tick: Tick) -> None:
        """What the tick was."""
        self._send(self._tick, encode_tick(tick), tick.stamp, tick.index)

    def health(self, diagnostics: list[Diagnostic], stamp: int, tick: int) -> None:
        """How the node is."""
        payload = encode_health(stamp, self._robot.name, diagnostics)
        self._send(self._health, payload, stamp, tick)

    def _send(self, outlet: Outlet, payload: bytes, stamp: int, tick: int) -> None:
        outlet.put(payload)
        if self._recorder is not None:
            self._recorder.write(Entry(outlet.key, outlet.kind, payload, False, stamp, stamp, tick))
