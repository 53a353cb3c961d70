"""What tests ask of a node that serves the small robot, and of the log it leaves."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import TypeVar

import numpy as np
import zenoh

from support.processes import Served
from tauten.model import Robot
from tauten.service.log import LogReader
from tauten.service.wire import (
    CDR,
    JSON,
    POINT,
    Cause,
    Diagnostic,
    Joints,
    Mode,
    Point,
    Tick,
    decode_health,
    decode_joints,
    decode_point,
    decode_tick,
    encode_point,
    point_json,
)

PERIOD = 0.02
T = TypeVar("T")


def point_at(beam: Robot, z: float, frame: str = "beam_base") -> Point:
    """A target above the tip at rest."""
    x, y, z0 = beam.effector(beam.rest())[0].tolist()
    return Point(time.time_ns(), frame, (x, y, z0 + z))


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


def last_health(served: Served) -> dict[str, Diagnostic]:
    """The next health message."""
    subscriber = served.session.declare_subscriber(
        served.keys.health, zenoh.handlers.FifoChannel(4)
    )
    found = decode_health(bytes(subscriber.recv().payload))
    assert isinstance(found, dict)
    return found


def recorded(log: Path, beam: Robot) -> tuple[list[Tick], list[Joints], list[Point]]:
    """Ticks, actuation and the model's tip of a log."""
    keys, ticks, joints, tips = LogReader(log), [], [], []
    for message in keys.messages():
        if message.key.endswith("/tick"):
            ticks.append(decode_tick(message.payload))
        elif message.key.endswith("/actuation"):
            joints.append(decode_joints(message.payload, CDR, beam.cable_names))
        elif message.key == "tauten/beam/effector":
            tips.append(decode_point(message.payload, CDR))
    assert all(isinstance(tick, Tick) for tick in ticks)
    assert all(isinstance(joint, Joints) for joint in joints)
    return ticks, joints, tips  # type: ignore[return-value]


def check_limits(joints: list[Joints], beam: Robot) -> None:
    """Every actuation that left is finite, within limits, within the rate."""
    limits = beam.limits
    pull = np.array([joint.pull for joint in joints])
    tension = np.array([joint.tension for joint in joints])
    assert np.isfinite(pull).all()
    assert np.isfinite(tension).all()
    assert ((limits.pull_min <= pull) & (pull <= limits.pull_max)).all()
    assert ((limits.tension_min <= tension) & (tension <= limits.tension_max)).all()
    steps = np.abs(np.diff(pull, axis=0, prepend=0.0))
    assert (steps <= limits.rate * PERIOD * (1.0 + 1e-12)).all()


def ordered(values: Sequence[T]) -> list[T]:
    """Values without those that repeat the one before."""
    return [value for i, value in enumerate(values) if i == 0 or values[i - 1] != value]


def modes(ticks: list[Tick]) -> list[tuple[Mode, Cause]]:
    return ordered([(tick.mode, tick.cause) for tick in ticks])


def whole(ticks: list[Tick]) -> bool:
    """Whether every tick is there, one after another."""
    return [tick.index for tick in ticks] == list(range(len(ticks)))


def follow(served: Served, beam: Robot, seconds: float) -> None:
    send(served, beam, 0.005, seconds)


def wait_mode(served: Served, mode: Mode) -> Tick:
    """Wait until the node is in a mode for some ticks; the last of them."""
    ticks = served.session.declare_subscriber(served.keys.tick, zenoh.handlers.RingChannel(1))
    end, count = time.monotonic() + 60.0, 0
    while time.monotonic() < end:
        sample = ticks.try_recv()
        if sample is None:
            time.sleep(0.005)
            continue
        tick = decode_tick(bytes(sample.payload))
        assert isinstance(tick, Tick)
        count = count + 1 if tick.mode is mode else 0
        if count >= 5:
            ticks.undeclare()  # type: ignore[no-untyped-call]
            return tick
    raise AssertionError(f"no {mode} within a minute, last {tick.mode} ({tick.cause})")
