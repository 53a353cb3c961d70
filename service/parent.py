"""Processes that end with the one that started them, also where that is killed.

It is outside of `tauten.service.process`, which loads the model: every command imports it.
"""

from __future__ import annotations

import os
import signal
import sys

PARENT = "TAUTEN_PARENT"  # environment variable: number of the process that a command ends with
_PR_SET_PDEATHSIG = 1  # of linux/prctl.h


def end_with(parent: int) -> None:
    """Have this process asked to end (SIGTERM) when its parent has ended, however that has.

    Only Linux can do that; elsewhere the process outlives a parent that is killed.
    """
    if sys.platform != "linux":
        return
    import ctypes  # most commands need it not

    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, int(signal.SIGTERM))
    if os.getppid() != parent:  # it has ended before
        os.kill(os.getpid(), signal.SIGTERM)
