"""What the distance of plant and model in a run consists of, on a run of a known plant."""

from __future__ import annotations

import json
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from support.messages import Point, encode_point

from tauten.controller import Controller
from tauten.model import Simulator
from tauten.service.cli import main
from tauten.service.codec.messages import POINT
from tauten.service.describing import log_metadata
from tauten.service.log import Entry, LogRecorder
from tauten.service.node import ControlLoop, Signals
from tauten.service.replay import Distances, measure_distances
from tauten.service.setup import load_setup
from tauten.service.wire import (
    HEALTH,
    JOINTS,
    TICK,
    Diagnostic,
    Joints,
    Keys,
    Level,
    Tick,
    encode_health,
    encode_joints,
    encode_tick,
)

TICKS, PERIOD = 40, 20_000_000  # ns


def write_run(file: Path, log: Path, kind: str) -> None:
    """A run whose plant uses each actuation a tick later, without a clock and a network."""
    setup = load_setup(file)
    robot, keys = setup.robot, Keys(setup.robot.name)
    controller, recorder = Controller(robot), LogRecorder(log, log_metadata(setup))
    assert controller.settle_start().converged
    loop = ControlLoop(controller)
    plant, command = Simulator(robot), np.zeros(robot.n_a)
    rest = robot.effector(robot.rest())
    steps = {"steps": kind, "steps_per_period": "2", "drive": "pull"}
    for index in range(TICKS):
        stamp = 10**18 + index * PERIOD
        goal = rest + 1e-4 * min(index, 20) * np.array([[0.0, 0.0, 1.0]])
        action = loop.tick(goal, Signals(target=True))
        loop.prepare()
        if kind == "own":
            plant.move(position=command, steps=2)
        else:
            plant.step(position=command, converged=kind == "converged")
        command = action.actuation.position
        names = robot.actuators.names
        position, effort = tuple(command.tolist()), tuple(action.actuation.effort.tolist())
        x, y, z = action.actuation.effector[0].tolist()
        tick = Tick(
            stamp, robot.frame, index, action.mode, action.cause,
            "" if action.status is None else action.status.name,
            tuple((a, b, c) for a, b, c in goal.tolist()), (), 0, 0.0, 0.0, 0.0, 0.0, 0.0, 0,
            0.0, 0.0, 0.0, 0, False, tuple(goal.ravel().tolist()),
        )  # fmt: skip
        health = Diagnostic("plant", Level.OK, "", steps)
        model, real = (
            encode_point(Point(stamp, robot.frame, (a, b, c)))
            for a, b, c in ((x, y, z), tuple(plant.effector[0].tolist()))
        )
        for key, kind, payload in (
            (
                keys.actuation,
                JOINTS,
                encode_joints(Joints(stamp, robot.frame, names, position, effort)),
            ),
            (keys.effectors(("",))[0], POINT, model),
            (keys.plant_effectors(("",))[0], POINT, real),
            (keys.plant_health, HEALTH, encode_health(stamp, robot.name, [health])),
            (keys.tick, TICK, encode_tick(tick)),
        ):
            recorder.write(Entry(key, kind, payload, stamp, stamp, index))
    recorder.close()


@pytest.fixture(scope="module", params=["single", "converged", "own"])
def log(
    request: pytest.FixtureRequest, beam_file: Path, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, str]:
    folder = tmp_path_factory.mktemp("run")
    for name in ("beam.toml", "beam.vtu"):  # a replay opens files beside the log
        shutil.copy(beam_file.parent / name, folder)
    write_run(folder / "beam.toml", folder / "log.mcap", request.param)
    return folder / "log.mcap", request.param


@pytest.fixture(scope="module")
def found(log: tuple[Path, str]) -> Distances:
    return measure_distances(log[0], False, lambda share, what: None)


def test_steps_of_the_plant_are_read_from_its_health(
    log: tuple[Path, str], found: Distances
) -> None:
    assert found.steps == log[1]


def test_the_delay_is_the_motion_in_a_tick(log: tuple[Path, str], found: Distances) -> None:
    """The plant is a tick late, and nothing else differs between it and its simulation."""
    shares = found.shares()
    # of what was decided with one linearisation from the model itself, which is a full one
    assert shares["state reduction"].max_mm == pytest.approx(0.0, abs=1e-2)
    assert shares["contact basis"].max_mm == pytest.approx(0.0, abs=1e-9)
    delay, tick = shares["delay"].max_mm, shares["motion of the model in a tick"].max_mm
    time, whole = shares["time"].max_mm, shares["model without contact"].max_mm
    assert delay is not None and time is not None
    assert delay == pytest.approx(tick, rel=0.1)
    assert 0.0 < time < (0.05 if log[1] == "own" else 0.5) * delay
    assert whole == pytest.approx(time, abs=1e-2)


@pytest.mark.long
@pytest.mark.parametrize("log", ["own"], indirect=True)
def test_the_command_shows_and_writes_the_shares(
    log: tuple[Path, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    command = ["tauten", "replay", str(log[0]), "--distance", "--report", str(tmp_path / "out")]
    monkeypatch.setattr(sys, "argv", command)
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 0
    assert json.loads((tmp_path / "out" / "distance.json").read_text())["delay"]["max_mm"] > 0.0
    assert (tmp_path / "out" / "distance.png").stat().st_size > 1000
