"""The process that compares a reduced model with the full one ends also on a busy machine."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from tauten.service.node.model_watch import leave_idle_class


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
