"""A node in closed loop over real Zenoh: operator, measurement, and a plant softer than its model."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from support.messages import encode_command
from support.nodes import (
    check_limits,
    reached,
    recorded,
    streaming,
    undisturbed,
    wait_health,
    wait_mode,
    wait_slack,
    wait_tip,
)
from support.processes import Process, Served, client_of, start, wait_alive

from tauten.model import Robot
from tauten.service.link import close_session
from tauten.service.plant import free_ports
from tauten.service.replay import read_run, replay
from tauten.service.wire import (
    CDR,
    JSON,
    TEXT,
    Cause,
    Keys,
    Mode,
    OperatorCommand,
)

TIP = "tauten/beam/effector"


def order(served: Served, command: OperatorCommand) -> None:
    payload = encode_command(command)
    served.session.put(served.keys.command, payload, encoding=f"{CDR};{TEXT}")


@pytest.mark.long
def test_an_operator_holds_enables_stops_and_resets(served: Served, beam: Robot) -> None:
    order(served, OperatorCommand.RESET)  # nothing to reset: refused
    goal = reached(beam, 0.003)
    with streaming(served, goal):
        wait_mode(served, Mode.RUN)
        order(served, OperatorCommand.HOLD)
        wait_mode(served, Mode.HOLD, Cause.OPERATOR)
        served.session.put(served.keys.command, b'{"data": "enable"}', encoding=JSON)
        wait_tip(served, TIP, goal, 1e-3)
        order(served, OperatorCommand.STOP)
        wait_mode(served, Mode.STOP, Cause.OPERATOR)
        wait_slack(served, beam)
        order(served, OperatorCommand.RESET)
        wait_mode(served, Mode.RUN)
        served.session.put(served.keys.command, b"explode", encoding="text/plain")
        served.session.put(served.keys.command, b'{"data": "fire"}', encoding=JSON)
        counts = wait_health(
            served, lambda found: found["commands"].values.get("refused_unknown_command") == "1"
        )["commands"].values
    assert served.process.end() == 0
    ticks, joints, _ = recorded(served.log, beam)
    seen = undisturbed(ticks)
    assert seen[:4] == [
        (Mode.RUN, Cause.NONE),
        (Mode.HOLD, Cause.OPERATOR),
        (Mode.RUN, Cause.NONE),
        (Mode.STOP, Cause.OPERATOR),
    ]
    assert (Mode.RUN, Cause.NONE) in seen[4:]  # after the reset
    stopped = [i for i, t in enumerate(ticks) if t.cause is Cause.OPERATOR and t.mode is Mode.STOP]
    assert joints[stopped[0]].position[1] > 1e-4
    assert joints[stopped[-1]].position == (0.0, 0.0)
    check_limits(joints, beam)
    assert replay(served.log, tolerance=1e-9, recorded_paths=True).same
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
    session = client_of(node, port)
    try:
        wait_alive(session, Keys("beam").token, node)
        wait_alive(session, Keys("beam").plant_token, plant)
        yield Served(node, session, Keys("beam"), port, log), plant
    finally:
        close_session(session)
        for process in (node, plant):
            if process.process.poll() is None:
                process.process.kill()
            process.process.wait()


@pytest.mark.long
def test_measurements_remove_a_mismatch_and_their_loss_holds(
    closed: tuple[Served, Process], beam: Robot
) -> None:
    served, plant = closed
    goal = reached(beam, 0.004)
    with streaming(served, goal):
        wait_tip(served, served.keys.plant_effectors(("tip",))[0], goal, 5e-4)
        assert plant.end() == 0  # and with it the measurements
        wait_mode(served, Mode.HOLD, Cause.UNMEASURED)
    assert served.process.end() == 0
    run = read_run(served.log)
    away = np.linalg.norm(run.plant.value - goal, axis=1)
    model = np.linalg.norm(run.model.value - goal, axis=1)
    length = 0.1
    assert away[-5:].max() < 0.01 * length
    together = run.model.time <= run.plant.time[-1]
    assert model[together][-1] > 2.0 * away[-1]  # the model is off instead, by the mismatch
    assert undisturbed(run.ticks)[-2:] == [
        (Mode.HOLD, Cause.UNMEASURED),
        (Mode.STOP, Cause.SHUTDOWN),
    ]
    joints = recorded(served.log, beam)[1]
    check_limits(joints, beam)
    assert replay(
        served.log, tolerance=1e-9, recorded_paths=True
    ).same  # the correction is in the log
