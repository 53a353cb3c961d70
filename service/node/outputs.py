"""Messages that leave a node, and their copies in its log.

Actuation always leaves. The model's effectors and the tick are encoded only when there is a subscriber or a
log: at a kilohertz their encoding is a twentieth of the period.

For viewers there are a cloud of the skin's vertices and the ends of the cables on the key `surface`, and
one of the contacts that push on `contacts`, while somebody listens and in time that is left. What joins the
points never changes and is in the description.
"""

from __future__ import annotations

import time

import numpy as np
import zenoh

from tauten.controller import Controller
from tauten.model import Robot, SkinMesh, skin_of
from tauten.service.log import Entry, LogRecorder
from tauten.service.node.clock import Clock
from tauten.service.node.loop import Action
from tauten.service.wire import (
    CLOUD,
    CONTACT_FIELDS,
    HEALTH,
    JOINTS,
    MESSAGE_TYPES,
    SKIN_FIELDS,
    TICK,
    Cloud,
    Diagnostic,
    EffectorMessage,
    Joints,
    Keys,
    Level,
    Mode,
    Publisher,
    Tick,
    encode_cloud,
    encode_effector,
    encode_joints,
    encode_tick,
)

_PERIOD = 1.0 / 30.0  # s between two surfaces
_MARGIN = 1.5  # times the last duration must be left of the period
_FIRST = 1e-3  # s, expected before the first
_FADE = 0.95  # of the expected duration each time it is not left, so that a hiccup is forgotten
_SPARE = 3e-4  # s left for other work


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
            Publisher(session, key, MESSAGE_TYPES[kind], urgent=False)
            for key, kind in zip(
                keys.effectors(robot.effector_names), robot.effector_layout.kinds, strict=True
            )
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
            tuple(actuation.position.tolist()), tuple(actuation.effort.tolist()),
        )  # fmt: skip
        self._send(self._actuation, encode_joints(joints), stamp, tick)
        if action.mode is Mode.STOP:  # the model does not follow a release
            return
        layout, values = robot.effector_layout, actuation.effector_values
        for i, publisher in enumerate(self._effectors):
            if self._is_used(publisher):
                own = tuple(values[layout.values_of(i)].tolist())
                message = EffectorMessage(stamp, robot.frame, own)
                payload = encode_effector(layout.kinds[i], layout.names[i], message)
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


class ShapePublisher:
    """Publishes the skin and the contacts of the model that decides.

    Attributes:
        published: number of surfaces.
    """

    def __init__(self, session: zenoh.Session, robot: Robot) -> None:
        """Declare the publishers.

        Args:
            session: open Zenoh session.
            robot: that is served.
        """
        keys = Keys(robot.name)
        self._surface = Publisher(session, keys.surface, CLOUD, urgent=False)
        self._contacts = Publisher(session, keys.contacts, CLOUD, urgent=False)
        self._frame = robot.frame
        self._skin: SkinMesh = skin_of(robot)
        self.published = 0
        self._next = 0.0
        self._expected = _FIRST

    def publish(self, controller: Controller, clock: Clock) -> None:
        """Publish where the model is, if it is time, somebody listens and enough of the period is left.

        Args:
            controller: whose model is shown.
            clock: of the loop.
        """
        now = time.monotonic()
        if now < self._next or not self._surface.has_subscribers:
            return
        if clock.remaining < _MARGIN * self._expected + _SPARE:
            self._expected *= _FADE
            return
        self._next = now + _PERIOD
        wants_contacts = self._contacts.has_subscribers
        state = controller.state
        forces = controller.contact_forces if wants_contacts else None
        geometry = self._skin.geometry(controller.robot, state, forces)
        stamp = time.time_ns()
        points = np.concatenate([geometry.vertices, geometry.segments.reshape(-1, 3)])
        self._surface.put(encode_cloud(Cloud(stamp, self._frame, points), SKIN_FIELDS))
        if wants_contacts:
            pushing = np.hstack([geometry.contacts.points, geometry.contacts.forces])  # (c, 6)
            self._contacts.put(encode_cloud(Cloud(stamp, self._frame, pushing), CONTACT_FIELDS))
        self.published += 1
        self._expected = time.monotonic() - now

    def diagnostic(self) -> Diagnostic:
        """How many surfaces were published, and how long the last one took, as health."""
        milliseconds = 1e3 * self._expected if self.published else 0.0
        return Diagnostic(
            "surface",
            Level.OK,
            f"{self.published} published",
            {"published": str(self.published), "took_ms": f"{milliseconds:.4g}"},
        )
