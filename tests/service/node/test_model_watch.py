"""The process that compares a reduced model with the full one ends also on a busy machine."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest
from support.processes import blocks_interrupts

from tauten.controller import Controller, ModelSettings
from tauten.model import Robot
from tauten.service.node.model_watch import ModelWatch, leave_idle_class


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
