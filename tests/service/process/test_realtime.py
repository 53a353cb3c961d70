"""Priorities of processes."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

LOWER = """
import os, subprocess, sys
from tauten.service.process import give_lower_priority
with subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE) as other:
    give_lower_priority(other.pid)
    print(os.getpriority(os.PRIO_PROCESS, other.pid) - os.getpriority(os.PRIO_PROCESS, 0))
    other.communicate(b"\\n")
"""


@pytest.mark.parametrize("nice", [0, 7, 15])
def test_another_process_is_less_urgent_than_the_caller_under_nice_too(nice: int) -> None:
    """A niceness of 10 was a higher priority under nice -n 15, and refused to ordinary users."""
    own = min(os.getpriority(os.PRIO_PROCESS, 0) + nice, 19)
    command = ["nice", "-n", str(nice), sys.executable, "-c", LOWER]
    done = subprocess.run(command, check=True, capture_output=True, text=True, timeout=300.0)
    assert int(done.stdout) == min(10, 19 - own)
