"""Messages that leave a node, and their copies in its log.

Actuation always leaves. The model's effectors and the tick are encoded only when there is a subscriber or a
log: at a kilohertz their encoding is a twentieth of the period.

So are the contacts that push, the wrenches on obstacles and parts, and where these are if they move.

For viewers there is a cloud of the skin's vertices and the ends of the cables on the key `surface`, while
somebody listens and in time that is left. What joins the points never changes and is in the description.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
import zenoh

from tauten.controller import Controller
from tauten.model import (
    ContactForces,
    ObstaclePoses,
    Robot,
    SkinMesh,
    contact_wrenches,
    skin_of,
    touched_names,
)
from tauten.service.log import Entry, LogRecorder
from tauten.service.node.clock import Clock
from tauten.service.node.loop import Action
from tauten.service.wire import (
    CERTIFIED,
    CLOUD,
    CONTACT_FIELDS,
    HEALTH,
    JOINTS,
    MESSAGE_TYPES,
    ODOMETRY,
    SKIN_FIELDS,
    TICK,
    WRENCH,
    Cloud,
    Diagnostic,
    EffectorMessage,
    Joints,
    Keys,
    Level,
    Mode,
    ObstacleState,
    Publisher,
    Tick,
    contact_cloud,
    encode_cloud,
    encode_effector,
    encode_joints,
    encode_obstacle,
    encode_tick,
    encode_wrench,
)

_PERIOD = 1.0 / 30.0  # s between two surfaces
_MARGIN = 1.5  # times the last duration must be left of the period
_FIRST = 1e-3  # s, expected before the first
_FADE = 0.95  # of the expected duration each time it is not left, so that a hiccup is forgotten
_SPARE = 3e-4  # s left for other work


@dataclass(frozen=True, slots=True)
class Readout:
    """What the model touches after a tick.

    Attributes:
        contacts: in range with their forces.
        obstacles: where they are.
    """

    contacts: ContactForces
    obstacles: ObstaclePoses


class NodeOutputs:
    """Publishes what a node sends."""

    def __init__(self, session: zenoh.Session, robot: Robot, recorder: LogRecorder | None) -> None:
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
        names = robot.obstacles.names
        self._contacts = Publisher(session, keys.contacts, CLOUD, urgent=False)
        self._open = Publisher(session, keys.open_contacts, CLOUD, urgent=False)
        self._wrenches = [
            Publisher(session, keys.wrench(name), WRENCH, urgent=False)
            for name in touched_names(robot)
        ]
        self._moving = [
            number for number, one in enumerate(robot.obstacles.obstacles) if one.may_move
        ]
        self._places = [
            Publisher(session, keys.obstacle_state(names[number]), ODOMETRY, urgent=False)
            for number in self._moving
        ]
        self._health = Publisher(session, keys.health, HEALTH, urgent=False)

    def actuate(self, action: Action, stamp: int, tick: int) -> None:
        """Publish actuation, then the model's effectors after the tick; with a stamp [ns since the epoch]."""
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

    def readout(self, controller: Controller, mode: Mode) -> Readout | None:
        """What the model touches, where somebody wants to know it; None in a release."""
        wanted = (self._contacts, *self._wrenches, *self._places)
        used = self._open.has_subscribers or any(map(self._is_used, wanted))
        if self._robot.n_c == 0 or mode is Mode.STOP or not used:
            return None
        return Readout(controller.contacts, controller.obstacles)

    def tick(self, tick: Tick, readout: Readout | None) -> None:
        """Publish a tick, and what the model touches after it."""
        if readout is not None:
            self._touch(readout, tick)
        if self._is_used(self._tick):
            self._send(self._tick, encode_tick(tick), tick.stamp, tick.index)

    def _touch(self, readout: Readout, tick: Tick) -> None:
        """Publish contacts, wrenches and where obstacles are."""
        at, frame = (tick.stamp, tick.index), self._robot.frame
        contacts, obstacles = readout.contacts, readout.obstacles
        if self._is_used(self._contacts):
            cloud = contact_cloud(tick.stamp, frame, contacts)
            self._send(self._contacts, encode_cloud(cloud, CONTACT_FIELDS), *at)
        if self._open.has_subscribers:  # a log does not need them
            cloud = contact_cloud(tick.stamp, frame, contacts, pushing=False)
            self._open.put(encode_cloud(cloud, CONTACT_FIELDS))
        used = [(i, one) for i, one in enumerate(self._wrenches) if self._is_used(one)]
        if used:
            wrenches = contact_wrenches(self._robot, contacts)
            for i, publisher in used:
                self._send(publisher, encode_wrench(tick.stamp, frame, wrenches[i]), *at)
        for number, publisher in zip(self._moving, self._places, strict=True):
            if self._is_used(publisher):
                name, pose = obstacles.names[number], obstacles.poses[number]
                state = ObstacleState(tick.stamp, frame, name, pose)
                self._send(publisher, encode_obstacle(state), *at)

    def health(self, payload: bytes, stamp: int, tick: int) -> None:
        """Publish encoded health with a stamp [ns since the epoch]."""
        self._send(self._health, payload, stamp, tick)

    def _is_used(self, publisher: Publisher) -> bool:
        return self._recorder is not None or publisher.has_subscribers

    def _send(self, publisher: Publisher, payload: bytes, stamp: int, tick: int) -> None:
        publisher.put(payload)
        if self._recorder is not None:
            entry = Entry(publisher.key, publisher.kind, payload, stamp, stamp, tick)
            self._recorder.write(entry)


def contact_diagnostic(controller: Controller) -> Diagnostic:
    """How many contacts push, the normal force of each pair, and limits that are not kept, for health."""
    found, values = controller.contacts, dict[str, str]()
    normal, pairs = found.normal_force, controller.robot.pairs
    for number, pair in enumerate(pairs):
        values[f"{pair.name} [N]"] = f"{normal[found.contacts.pair == number].sum():.4g}"
    pushing, sliding = int(found.pushing.sum()), int(found.sliding.sum())
    values |= {"in_range": str(len(found)), "pushing": str(pushing), "sliding": str(sliding)}
    said = f"{pushing} push with {normal.sum():.3g} N"
    certificate = controller.certified(quickly=True)
    if certificate is not None:
        values |= {key: f"{getattr(certificate, name):.2g}" for name, key in CERTIFIED.items()}
        values["doubts"] = "; ".join(certificate.doubts) or "none"
        said = ", ".join((said, *certificate.doubts))
    grasp, level = controller.grasp, Level.OK
    if grasp is not None:
        values["kept"] = "; ".join(grasp.kept_names) or "none"
        values["last_let_go"] = "; ".join(grasp.released) or "none"
        if exceeded := grasp.exceeded(found):
            level, said = Level.WARN, f"{said}; not kept: {', '.join(exceeded)}"
    return Diagnostic("contacts", level, said, values)


class ShapePublisher:
    """Publishes the skin of the model that decides.

    Attributes:
        published: number of surfaces.
    """

    def __init__(self, session: zenoh.Session, robot: Robot) -> None:
        keys = Keys(robot.name)
        self._surface = Publisher(session, keys.surface, CLOUD, urgent=False)
        self._frame = robot.frame
        self._skin: SkinMesh = skin_of(robot)
        self.published = 0
        self._next = 0.0
        self._expected = _FIRST

    def publish(self, controller: Controller, clock: Clock) -> None:
        """Publish where the model is, if it is time, somebody listens and enough of the period is left."""
        now = time.monotonic()
        if now < self._next or not self._surface.has_subscribers:
            return
        if clock.remaining < _MARGIN * self._expected + _SPARE:
            self._expected *= _FADE
            return
        self._next = now + _PERIOD
        geometry = self._skin.geometry(controller.robot, controller.state, None)
        stamp = time.time_ns()
        points = np.concatenate([geometry.vertices, geometry.segments.reshape(-1, 3)])
        self._surface.put(encode_cloud(Cloud(stamp, self._frame, points), SKIN_FIELDS))
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
