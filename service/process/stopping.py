"""Ctrl-C and SIGTERM as a flag that a loop looks at, so that every exit is an orderly one."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


class StopFlag:
    """Whether somebody has asked to stop."""

    def __init__(self) -> None:
        self.requested = False

    def request(self) -> None:
        """Ask to stop."""
        self.requested = True


@contextmanager
def stop_on_signals() -> Iterator[StopFlag]:
    """A flag that SIGINT and SIGTERM raise; the old handlers come back afterwards."""
    flag = StopFlag()

    def handler(_signal: int, _frame: FrameType | None) -> None:
        flag.request()

    old = {number: signal.signal(number, handler) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield flag
    finally:
        for number, before in old.items():
            signal.signal(number, before)
