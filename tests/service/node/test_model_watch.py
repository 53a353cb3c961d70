"""The process that compares a reduced model with the full one ends also on a busy machine."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.processes import ROBOT, blocks_interrupts, write_robot

from tauten.controller import Controller, ModelSettings
from tauten.model import Robot, load_robot
from tauten.service.node import ControlLoop, Signals
from tauten.service.node.model_watch import FallBack, ModelWatch, leave_idle_class
from tauten.service.settings import ServiceSettings


def test_a_process_of_the_idle_class_becomes_ordinary() -> None:
    """On a busy machine one of the idle class gets no time, not even to be killed."""
    with subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE) as child:
        try:
            os.sched_setscheduler(child.pid, os.SCHED_IDLE, os.sched_param(0))
        except OSError:
            pytest.skip("this sandbox has no idle class")
        leave_idle_class(child.pid)
        assert os.sched_getscheduler(child.pid) == os.SCHED_OTHER


def test_a_process_that_has_ended_is_no_error() -> None:
    with subprocess.Popen([sys.executable, "-c", ""]) as child:
        child.wait()
        leave_idle_class(child.pid)


def test_nothing_waits_for_the_process(finger: Robot) -> None:
    """A model larger than a pipe is read only when the interpreter has started, seconds later."""
    controller = Controller(finger, "none")
    watch = ModelWatch(finger, "none", ModelSettings())
    assert watch._sending.is_alive(), "the process is still starting"
    watch.look(controller)
    assert watch.diagnostic().message == "reduced, not compared yet"
    watch.close()
    assert not watch._sending.is_alive() and not watch._process.is_alive()


def test_ctrl_c_does_not_reach_the_process_while_it_starts(finger: Robot) -> None:
    """A terminal sends it to all processes; one that still imports ended in a traceback."""
    watch = ModelWatch(finger, "none", ModelSettings())
    try:
        assert blocks_interrupts(watch._process.pid)
    finally:
        watch.close()


def test_a_full_model_that_fails_at_once_leaves_the_release_to_the_reduced_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The release had the steps of the full model's ticks, and went on at the reduced one's rate."""
    file = write_robot(tmp_path, ROBOT)
    reduced = Controller(load_robot(file), "none")
    full = Controller(load_robot(file, rate=5.0), "none")
    loop, watch = (
        ControlLoop(reduced, settings=ServiceSettings(release_time=0.01)),
        SimpleNamespace(),
    )
    goal = reduced.effector + np.array([0.0, 0.0, 0.01])
    for _ in range(20):
        loop.tick(goal, Signals(target=True))
        loop.prepare()

    def fails() -> None:
        raise ZeroDivisionError("they coincide")

    monkeypatch.setattr(full, "prepare", fails)
    lifting: Any = SimpleNamespace(body=SimpleNamespace(lifted=lambda state: state))
    with pytest.raises(ZeroDivisionError):
        FallBack(watch, lifting, full).switch(loop)  # type: ignore[arg-type]
    positions = [reduced.position]
    assert positions[0].max() > 1e-3
    while not loop.released:
        positions.append(loop.tick(None, Signals(False, shutdown=True)).actuation.position)
    moves = np.abs(np.diff(positions, axis=0))
    assert (moves <= (1.0 + 1e-9) * reduced.robot.limits.rate * reduced.robot.h).all()
