"""The log of a run without clock and network."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from support.messages import Point, encode_point
from support.processes import ROBOT
from tauten.controller import Controller
from tauten.service.codec.messages import POINT
from tauten.service.describing import log_metadata
from tauten.service.log import Entry, LogReader, LogRecorder
from tauten.service.node import ControlLoop, Signals
from tauten.service.setup import Setup
from tauten.service.wire import (
    FLOAT,
    JOINTS,
    TICK,
    Joints,
    Keys,
    Tick,
    encode_float,
    encode_joints,
    encode_tick,
)

TICKS = 60
LAG = 0.001  # m, the pretended plant is that much too low
HEAVY = ROBOT.replace("gravity = [0.0, 0.0, 0.0]", "gravity = [0.0, 0.0, -2.0]")


def write_run(setup: Setup, path: Path) -> None:
    """The log of a run without clock and network: the loop as it is, times made up."""
    robot, keys = setup.robot, Keys(setup.robot.name)
    controller, recorder = Controller(robot), LogRecorder(path, log_metadata(setup))
    assert controller.settle_start().converged
    loop = ControlLoop(controller, settings=setup.service)
    rest = robot.effector(robot.rest())
    for index in range(TICKS + 20):
        stamp = 10**18 + index * 20_000_000
        goal = None
        if 5 <= index < TICKS - 10:
            goal = rest + np.array([[0.0, 0.0, 1e-4 * index], [0.0, 0.0, 3e-5 * index]])
        ends, hurried = index >= TICKS, index >= TICKS + 5  # a second Ctrl-C
        action = loop.tick(goal, Signals(goal is not None, shutdown=ends, hurried=hurried))
        loop.prepare()
        x, y, z = action.actuation.effector[0].tolist()
        joints = Joints(
            stamp,
            robot.frame,
            robot.actuators.names,
            tuple(action.actuation.position),
            tuple(action.actuation.effort),
        )
        tick = Tick(
            stamp, robot.frame, index, action.mode, action.cause,
            "" if action.status is None else action.status.name,
            () if goal is None else tuple((a, b, c) for a, b, c in goal.tolist()),
            (), 0, 1e-4 * (index % 10), 2e-3 if goal is not None else float("nan"), 1e-3, 5e-3 + 1e-4 * index,
            -0.001 if index == 30 else 0.01, 2 if index == 30 else 0,
            action.actuation.certificate.deepest_gap, 0.0, 0.0, 0,
            action.actuation.clamped, () if goal is None else tuple(goal.ravel().tolist()),
        )  # fmt: skip
        for key, kind, payload in (
            (keys.actuation, JOINTS, encode_joints(joints)),
            (keys.effectors(("",))[0], POINT, encode_point(Point(stamp, "", (x, y, z)))),
            (
                keys.plant_effectors(("",))[0],
                POINT,
                encode_point(Point(stamp, "", (x, y, z - LAG))),
            ),
            (keys.plant_gap, FLOAT, encode_float(0.002 - 1e-4 * index)),
            (keys.tick, TICK, encode_tick(tick)),
        ):
            recorder.write(Entry(key, kind, payload, stamp, stamp, index))
    recorder.close()


def with_entry(description: str, place: str, value: object) -> str:
    """A description as JSON with another value at a place such as "actuators.0.kind"; None removes it."""
    found = json.loads(description)
    *parents, last = (int(part) if part.isdigit() else part for part in place.split("."))
    entries = found
    for part in parents:
        entries = entries[part]
    if value is None:
        del entries[last]
    else:
        entries[last] = value
    return json.dumps(found)


def doctored(log: Path, path: Path, metadata: dict[str, str]) -> Path:
    """The log with other metadata, written as a recorder writes them."""
    messages = list(LogReader(log).messages())
    recorder = LogRecorder(path, metadata)
    kinds = {"actuation": JOINTS, "tick": TICK}
    for m in messages:
        kind = kinds.get(m.key.rsplit("/", 1)[1])
        if kind is not None:
            recorder.write(Entry(m.key, kind, m.payload, m.logged, m.logged, m.sequence))
    recorder.close()
    return path
