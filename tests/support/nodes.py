"""Checks of a node that serves the small robot, and of its log."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TypeVar

import numpy as np
import zenoh

from support.messages import Point, decode_point, encode_point, point_json
from support.processes import Served
from tauten.model import Robot, Simulator
from tauten.service.codec.messages import POINT
from tauten.service.link import close_session
from tauten.service.log import LogReader
from tauten.service.wire import (
    CDR,
    JSON,
    Cause,
    Diagnostic,
    Joints,
    Keys,
    Mode,
    Network,
    RobotDescription,
    Role,
    Tick,
    decode_health,
    decode_joints,
    decode_tick,
    open_session,
)

PERIOD = 0.02
PATIENCE = 180.0  # s, on a machine that is busy with something else
T = TypeVar("T")


def point_at(beam: Robot, z: float, frame: str = "beam_base", stamp: int | None = None) -> Point:
    """A target above the tip at rest, made now unless a stamp is given; 0 is for one without a time."""
    x, y, z0 = beam.effector(beam.rest())[0].tolist()
    return Point(time.time_ns() if stamp is None else stamp, frame, (x, y, z0 + z))


def reached(beam: Robot, position: float) -> tuple[float, float, float]:
    """Where the tip is when the upper cable is pulled so far [m]."""
    simulator = Simulator(beam, contact="none")
    assert simulator.settle(position=[0.0, position]).converged
    x, y, z = simulator.effector[0].tolist()
    return x, y, z


def send(served: Served, beam: Robot, z: float, seconds: float, json: bool = False) -> None:
    """Stream one target for a while."""
    publisher = served.session.declare_publisher(
        served.keys.targets(("tip",))[0], encoding=f"{JSON if json else CDR};{POINT}"
    )
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        point = point_at(beam, z)
        publisher.put(point_json(point) if json else encode_point(point))
        time.sleep(PERIOD)


def send_until_followed(served: Served, beam: Robot, z: float, ticks: int = 20) -> None:
    """Stream one target until so many were sent and so many ticks have followed; for busy machines."""
    key = served.keys.targets(("tip",))[0]
    seen = served.session.declare_subscriber(served.keys.tick, zenoh.handlers.RingChannel(256))
    end, sent, followed = time.monotonic() + PATIENCE, 0, 0
    while sent < ticks or followed < ticks:
        assert time.monotonic() < end, (
            f"{followed} of {ticks} ticks have followed within {PATIENCE:g} s"
        )
        served.session.put(key, encode_point(point_at(beam, z)), encoding=f"{CDR};{POINT}")
        sent += 1
        time.sleep(PERIOD)
        while (sample := seen.try_recv()) is not None:
            tick = decode_tick(bytes(sample.payload))
            followed += isinstance(tick, Tick) and tick.mode is Mode.RUN
    seen.undeclare()  # type: ignore[no-untyped-call]


@contextmanager
def streaming(served: Served, goal: Sequence[float], json: bool = False) -> Iterator[None]:
    """Stream one target (3,) for the tip while the block runs."""
    stop = threading.Event()
    x, y, z = goal
    publisher = served.session.declare_publisher(
        served.keys.targets(("tip",))[0], encoding=f"{JSON if json else CDR};{POINT}"
    )

    def put() -> None:
        while not stop.wait(PERIOD):
            point = Point(time.time_ns(), "", (x, y, z))
            publisher.put(point_json(point) if json else encode_point(point))

    thread = threading.Thread(target=put)
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join()
        publisher.undeclare()  # type: ignore[no-untyped-call]


def last_health(served: Served) -> dict[str, Diagnostic]:
    """The next health message."""
    subscriber = served.session.declare_subscriber(
        served.keys.health, zenoh.handlers.RingChannel(4)
    )
    found = decode_health(bytes(subscriber.recv().payload))
    assert isinstance(found, dict)
    return found


def wait_health(
    served: Served, wanted: Callable[[dict[str, Diagnostic]], bool]
) -> dict[str, Diagnostic]:
    """Wait for a health message with an entry."""
    end = time.monotonic() + PATIENCE
    while not wanted(found := last_health(served)):
        assert time.monotonic() < end, found
    return found


def wait_for(served: Served, key: str, wanted: Callable[[bytes], bool], what: str) -> bytes:
    """Wait until five messages of a key in a row are as wanted; the last of them."""
    messages = served.session.declare_subscriber(key, zenoh.handlers.RingChannel(1))
    end, count, payload = time.monotonic() + PATIENCE, 0, b""
    while count < 5:
        assert time.monotonic() < end, f"not within {PATIENCE:g} s: {what}"
        sample = messages.try_recv()
        if sample is None:
            time.sleep(0.005)
            continue
        payload = bytes(sample.payload)
        count = count + 1 if wanted(payload) else 0
    messages.undeclare()  # type: ignore[no-untyped-call]
    return payload


def wait_tip(served: Served, key: str, goal: Sequence[float], within: float) -> None:
    """Wait until a position is near a goal [m]."""

    def near(payload: bytes) -> bool:
        tip = decode_point(payload, CDR)
        assert isinstance(tip, Point)
        return bool(np.linalg.norm(np.subtract(tip.xyz, goal)) < within)

    wait_for(served, key, near, f"{key} within {within} m of {goal}")


def wait_slack(served: Served, beam: Robot) -> None:
    """Wait until no cable is pulled."""

    def slack(payload: bytes) -> bool:
        joints = decode_joints(payload, CDR, beam.actuators.names)
        assert isinstance(joints, Joints)
        return not any(joints.position)

    wait_for(served, served.keys.actuation, slack, "slack cables")


def recorded(log: Path, beam: Robot) -> tuple[list[Tick], list[Joints], list[Point]]:
    """Ticks, actuation and the model's tip of a log."""
    keys, ticks, joints, tips = LogReader(log), [], [], []
    for message in keys.messages():
        if message.key.endswith("/tick"):
            ticks.append(decode_tick(message.payload))
        elif message.key.endswith("/actuation"):
            joints.append(decode_joints(message.payload, CDR, beam.actuators.names))
        elif message.key == "tauten/beam/effector":
            tips.append(decode_point(message.payload, CDR))
    assert all(isinstance(tick, Tick) for tick in ticks)
    assert all(isinstance(joint, Joints) for joint in joints)
    return ticks, joints, tips  # type: ignore[return-value]


def check_limits(joints: list[Joints], beam: Robot) -> None:
    """Every actuation that left is finite, within limits, within the rate."""
    limits = beam.limits
    position = np.array([joint.position for joint in joints])
    effort = np.array([joint.effort for joint in joints])
    assert np.isfinite(position).all()
    assert np.isfinite(effort).all()
    assert ((limits.position_min <= position) & (position <= limits.position_max)).all()
    assert ((limits.effort_min <= effort) & (effort <= limits.effort_max)).all()
    steps = np.abs(np.diff(position, axis=0, prepend=0.0))
    assert (steps <= limits.rate * PERIOD * (1.0 + 1e-12)).all()


def ordered(values: Sequence[T]) -> list[T]:
    """Values without those that repeat the one before."""
    return [value for i, value in enumerate(values) if i == 0 or values[i - 1] != value]


def modes(ticks: list[Tick]) -> list[tuple[Mode, Cause]]:
    return ordered([(tick.mode, tick.cause) for tick in ticks])


def undisturbed(ticks: list[Tick]) -> list[tuple[Mode, Cause]]:
    """The modes without the holds of a machine that is busy with something else."""
    return ordered([item for item in modes(ticks) if item[1] not in (Cause.LATE, Cause.NO_TARGET)])


def whole(ticks: list[Tick]) -> bool:
    """Whether every tick is there, one after another."""
    return [tick.index for tick in ticks] == list(range(len(ticks)))


def follow(served: Served, beam: Robot, seconds: float) -> None:
    send(served, beam, 0.005, seconds)


def wait_mode(served: Served, mode: Mode, cause: Cause | None = None) -> Tick:
    """Wait until the node is in a mode, for a cause where one is given; its last tick."""

    def there(payload: bytes) -> bool:
        tick = decode_tick(payload)
        assert isinstance(tick, Tick)
        return tick.mode is mode and cause in (None, tick.cause)

    tick = decode_tick(wait_for(served, served.keys.tick, there, f"mode {mode} {cause or ''}"))
    assert isinstance(tick, Tick)
    return tick


@contextmanager
def answering(robot: RobotDescription, port: int) -> Iterator[zenoh.Session]:
    """A session that answers as the node of a robot does."""
    session = open_session(Network(port), Role.NODE, robot.name, connected=False)
    keys, answer = Keys(robot.name), robot.as_json().encode()
    questions = session.declare_queryable(
        keys.description, lambda query: query.reply(keys.description, answer)
    )
    token = session.liveliness().declare_token(keys.token)
    try:
        yield session
    finally:
        token.undeclare()  # type: ignore[no-untyped-call]
        questions.undeclare()  # type: ignore[no-untyped-call]
        close_session(session)
