"""A node in closed loop over real Zenoh: operator, measurement, and a plant softer than its model."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from support.nodes import PERIOD, check_limits, last_health, ordered, point_at, recorded
from support.processes import Process, Served, start, wait_alive

from tauten.model import Robot, Simulator
from tauten.service.plant import free_ports
from tauten.service.replay import read_run, replay
from tauten.service.wire import (
    CDR,
    JSON,
    POINT,
    TEXT,
    Cause,
    Keys,
    Mode,
    Network,
    OperatorCommand,
    Point,
    Role,
    encode_command,
    encode_point,
    open_session,
)


def send_for(served: Served, points: list[Point], key: str, seconds: float) -> None:
    """Stream points, each as often as a tick, for a while."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        for point in points:
            served.session.put(key, encode_point(point), encoding=f"{CDR};{POINT}")
        time.sleep(PERIOD)


def order(served: Served, command: OperatorCommand) -> None:
    payload = encode_command(command)
    served.session.put(served.keys.command, payload, encoding=f"{CDR};{TEXT}")


def test_an_operator_holds_enables_stops_and_resets(served: Served, beam: Robot) -> None:
    target = served.keys.targets(("tip",))[0]
    last_health(served)
    up = [point_at(beam, 0.006)]
    order(served, OperatorCommand.RESET)  # nothing to reset: refused
    send_for(served, up, target, 0.6)
    order(served, OperatorCommand.HOLD)
    send_for(served, up, target, 0.3)
    served.session.put(served.keys.command, b'{"data": "enable"}', encoding=JSON)
    send_for(served, up, target, 0.3)
    order(served, OperatorCommand.STOP)
    send_for(served, up, target, 0.9)  # the ramp takes 0.4 s
    order(served, OperatorCommand.RESET)
    send_for(served, up, target, 0.3)
    served.session.put(served.keys.command, b"explode", encoding="text/plain")
    served.session.put(served.keys.command, b'{"data": "fire"}', encoding=JSON)
    time.sleep(0.1)
    counts = last_health(served)["commands"].values
    assert served.process.end() == 0
    ticks, joints, _ = recorded(served.log, beam)
    seen = ordered([(tick.mode, tick.cause) for tick in ticks])
    assert seen[:5] == [
        (Mode.IDLE, Cause.NO_TARGET),
        (Mode.RUN, Cause.NONE),
        (Mode.HOLD, Cause.OPERATOR),
        (Mode.RUN, Cause.NONE),
        (Mode.STOP, Cause.OPERATOR),
    ]
    assert (Mode.RUN, Cause.NONE) in seen[5:]  # after the reset
    stopped = [i for i, t in enumerate(ticks) if t.cause is Cause.OPERATOR and t.mode is Mode.STOP]
    assert joints[stopped[0]].pull[1] > 1e-4
    assert joints[stopped[-1]].pull == (0.0, 0.0)
    check_limits(joints, beam)
    assert replay(served.log, tolerance=1e-9).same
    assert counts["accepted"] == "4"
    assert counts["refused_not_possible_now"] == "1"
    assert counts["refused_unknown_encoding"] == "1"
    assert counts["refused_unknown_command"] == "1"


@pytest.fixture
def closed(beam_file: Path, tmp_path: Path) -> Iterator[tuple[Served, Process]]:
    """A node in closed loop, and a plant with winches that pull forces, a fifth stiffer than the model."""
    port, log = free_ports(), tmp_path / "log.mcap"
    serving = ("serve", beam_file, "--port", port, "--record", log, "--closed-loop")
    behaving = ("--measure", "--young-scale", "1.2", "--drive", "tension")
    node = start(tmp_path / "serve.txt", *serving)
    plant = start(tmp_path / "plant.txt", "plant", beam_file, "--port", port, *behaving)
    session = open_session(Network(port), Role.OTHER, "beam")
    try:
        wait_alive(session, Keys("beam").token, node)
        wait_alive(session, Keys("beam").plant_token, plant)
        yield Served(node, session, Keys("beam"), port, log), plant
    finally:
        session.close()  # type: ignore[no-untyped-call]
        for process in (node, plant):
            if process.process.poll() is None:
                process.process.kill()
            process.process.wait()


def test_measurements_remove_a_mismatch_and_their_loss_holds(
    closed: tuple[Served, Process], beam: Robot
) -> None:
    served, plant = closed
    simulator = Simulator(beam, contact="none")
    assert simulator.settle(pull=[0.0, 0.004]).converged
    x, y, z = simulator.effector[0].tolist()
    target = [Point(0, "", (x, y, z))]
    key = served.keys.targets(("tip",))[0]
    send_for(served, target, key, 4.0)
    assert plant.end() == 0  # and with it the measurements
    send_for(served, target, key, 0.8)
    assert served.process.end() == 0
    run = read_run(served.log)
    away = np.linalg.norm(run.plant.value - simulator.effector[0], axis=1)
    model = np.linalg.norm(run.model.value - simulator.effector[0], axis=1)
    length = 0.1
    assert away[-5:].max() < 0.01 * length
    assert model[:200][-1] > 2.0 * away[-1]  # the model is off instead, by the mismatch
    causes = ordered([tick.cause for tick in run.ticks if tick.mode is not Mode.STOP])
    assert causes[-1] is Cause.UNMEASURED
    assert run.ticks[-1].mode is Mode.STOP
    joints = recorded(served.log, beam)[1]
    check_limits(joints, beam)
    assert replay(served.log, tolerance=1e-9).same  # the correction is in the log
