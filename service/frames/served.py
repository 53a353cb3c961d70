"""A robot that a node serves, elsewhere: its messages become frames, targets and commands go to it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import zenoh

from tauten.model import NO_CONTACTS, Floats, Geometry, PushingContacts
from tauten.model.contact import ObstaclePose
from tauten.model.numerics import Array
from tauten.service.frames.frame import RobotLook, ViewFrame
from tauten.service.link import put_command
from tauten.service.wire import (
    CDR,
    CONTACT_FIELDS,
    LARGEST_CLOUD,
    MESSAGE_TYPES,
    SKIN_FIELDS,
    Cause,
    Cloud,
    Diagnostic,
    EffectorMessage,
    Joints,
    Keys,
    Mode,
    ObstacleState,
    OperatorOrder,
    Rejection,
    RejectionReason,
    Tick,
    ask_description,
    decode_cloud,
    decode_effector,
    decode_health,
    decode_joints,
    decode_obstacle,
    decode_tick,
    encode_effector,
    payload_of,
    places_of,
)

_PATIENCE = 5.0  # s for the first answers of a node
_SILENT = 2.0  # s
_SILENT_PERIODS = 5  # and periods without a tick, after both of which a node is missing
_CONTACTS_AGE = 0.2  # s for which contacts belong to a surface


class ServedRobot:
    """A robot that a node serves.

    Attributes:
        look: what of the robot does not change.
        pausable: never: the robot moves whether one looks or not.
        locked: names of the actuators that are locked, by the node's health.
    """

    pausable = False

    def __init__(self, session: zenoh.Session, robot: str) -> None:
        """Ask for the description and subscribe.

        Raises:
            NetworkError: the node does not answer, or is of another version.
        """
        self._session, self._robot = session, robot
        description = ask_description(session, Keys(robot))
        unseen = np.zeros((description.surface.vertices, 3), np.float32)
        self.look = RobotLook(description, unseen)  # they are known with the first surface
        self._places = places_of(description.effectors)
        keys = Keys(robot)
        self._names = tuple(actuator.name for actuator in description.actuators)
        names = description.effector_names
        self._targets = [
            session.declare_publisher(
                key, encoding=f"{CDR};{MESSAGE_TYPES[effector.kind]}", express=True
            )
            for key, effector in zip(keys.targets(names), description.effectors, strict=True)
        ]
        subscribed = {
            "tick": keys.tick,
            "actuation": keys.actuation,
            "surface": keys.surface,
            "contacts": keys.contacts,
            "health": keys.health,
            **{
                f"effector {name}": key
                for name, key in zip(names, keys.effectors(names), strict=True)
            },
            **{
                f"obstacle {one.name}": keys.obstacle_state(one.name)
                for one in description.surface.obstacles
            },
        }
        self._rings = {
            name: session.declare_subscriber(key, zenoh.handlers.RingChannel(1))
            for name, key in subscribed.items()
        }
        self._first = 0  # stamp of the first tick [ns]
        self._tick: Tick | None = None
        self._heard = time.monotonic()
        self._joints: Joints | None = None
        self._skin: Cloud | None = None
        self._contacts: Cloud | None = None
        self._values = description.rest
        self._obstacles = dict[str, ObstaclePose]()
        self._health: tuple[str, ...] = ()
        self.locked: frozenset[str] = frozenset()
        self._refused = 0

    @property
    def notes(self) -> tuple[str, ...]:
        """What health warns of, and what does not arrive."""
        found = list(self._health)
        if self._skin is None:
            found.append("no surface yet: the node has no time to spare, or is of an older version")
        if self._refused:
            found.append(f"{self._refused} messages were not correct")
        return tuple(found)

    @property
    def silence(self) -> float:
        """Time for which the node has been missing [s]; 0 while it is there."""
        since = time.monotonic() - self._heard
        return since if since > max(_SILENT, _SILENT_PERIODS / self.look.robot.rate) else 0.0

    def command(self, command: OperatorOrder) -> None:
        """Send an operator's order."""
        put_command(self._session, self._robot, command)

    def advance(self, goal: Array | None, drawn: bool) -> ViewFrame | None:
        """Send targets, read what has arrived; see `SimulatedRobot.advance`."""
        if goal is not None:
            stamp, robot = time.time_ns(), self.look.robot
            for publisher, effector, place in zip(
                self._targets, robot.effectors, self._places, strict=True
            ):
                message = EffectorMessage(stamp, robot.frame, tuple(goal[place].tolist()))
                publisher.put(encode_effector(effector.kind, effector.name, message))
        if not drawn:
            return None
        self._read()
        return self._frame()

    def await_surface(self) -> None:
        """Wait for the first surface, so that the robot is seen from the start."""
        end = time.monotonic() + _PATIENCE
        while self._skin is None and time.monotonic() < end:
            self._read()
            time.sleep(0.02)
        if self._skin is not None:
            vertices = self._skin.values[: len(self.look.vertices)]
            self.look = replace(self.look, vertices=vertices)

    def _read(self) -> None:
        """Read the newest message of every key; the last correct one remains."""
        tick: Tick | None = self._newest("tick", decode_tick)
        if tick is not None:
            self._tick, self._heard = tick, time.monotonic()
            self._first = self._first or tick.stamp
        joints: Joints | None = self._newest(
            "actuation", lambda payload: decode_joints(payload, CDR, self._names)
        )
        skin: Cloud | None = self._newest("surface", self._decoded_skin)
        contacts: Cloud | None = self._newest(
            "contacts", lambda payload: decode_cloud(payload, CONTACT_FIELDS)
        )
        self._joints, self._skin = joints or self._joints, skin or self._skin
        self._contacts = contacts or self._contacts
        health: dict[str, Diagnostic] | None = self._newest("health", decode_health)
        if health is not None:
            bad = [one for one in health.values() if one.level]
            self._health = tuple(f"{one.name}: {one.message}" for one in bad)
            if "locks" in health:
                self.locked = frozenset(health["locks"].values) & frozenset(self._names)
        for effector, place in zip(self.look.robot.effectors, self._places, strict=True):
            decode = partial(decode_effector, effector.kind, effector.name, encoding=CDR)
            found: EffectorMessage | None = self._newest(f"effector {effector.name}", decode)
            if found is not None:
                self._values[place] = found.values
        for obstacle in self.look.robot.surface.obstacles:
            state: ObstacleState | None = self._newest(f"obstacle {obstacle.name}", decode_obstacle)
            if state is not None:
                self._obstacles[obstacle.name] = state.pose

    def _newest(self, name: str, decode: Callable[[bytes], Any]) -> Any:
        """The newest message of a key, decoded; None where there is none, or it was refused."""
        sample = self._rings[name].try_recv()
        if sample is None:
            return None
        payload = payload_of(sample, LARGEST_CLOUD)
        message = payload if isinstance(payload, Rejection) else decode(payload)
        if isinstance(message, Rejection):
            self._refused += 1
            return None
        return message

    def _decoded_skin(self, payload: bytes) -> Cloud | Rejection:
        """A surface with as many points as the description says."""
        cloud = decode_cloud(payload, SKIN_FIELDS)
        expected = len(self.look.vertices) + 2 * len(self.look.robot.surface.segments)
        if isinstance(cloud, Cloud) and len(cloud.values) != expected:
            detail = f"{len(cloud.values)} points, expected {expected}"
            return Rejection(RejectionReason.WRONG_SHAPE, detail)
        return cloud

    def _frame(self) -> ViewFrame | None:
        tick, joints, skin = self._tick, self._joints, self._skin
        if tick is None or joints is None or skin is None:
            return None
        count = len(self.look.vertices)
        vertices: Floats = skin.values[:count]
        segments: Floats = skin.values[count:].reshape(-1, 2, 3)
        goal = np.array(tick.goal_values)
        if goal.shape != self._values.shape:
            goal = np.full_like(self._values, np.nan)
        return ViewFrame(
            time=1e-9 * (tick.stamp - self._first),
            mode=Mode(tick.mode),
            cause=Cause(tick.cause),
            status=tick.status,
            geometry=Geometry(vertices, segments, self._pushing(skin)),
            position=np.array(joints.position),
            effort=np.array(joints.effort),
            goal=goal,
            values=self._values.copy(),
            step=tick.step,
            obstacles=dict(self._obstacles),
        )

    def _pushing(self, skin: Cloud) -> PushingContacts:
        cloud = self._contacts
        if cloud is None or abs(cloud.stamp - skin.stamp) > 1e9 * _CONTACTS_AGE:
            return NO_CONTACTS
        values = cloud.values
        sliding, margin = (values[:, CONTACT_FIELDS.index(name)] for name in ("sliding", "margin"))
        return PushingContacts(values[:, :3], values[:, 3:6], values[:, 6:9], sliding > 0.5, margin)
