r"""Signals that end a process, as a flag that a loop reads, so that every end is an orderly one.

| signal | from |
|---|---|
| SIGINT | Ctrl-C, the service manager; also where the shell of a script has it ignored in the background |
| SIGTERM | the system or a container that shuts down |
| SIGHUP | a terminal that is closed; ignored where the process was started with `nohup` |
| SIGQUIT | Ctrl-\ |
"""

from __future__ import annotations

import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType

_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)
_AGAIN = 0.3  # s; a second request sooner than that is the same one, sent to process and group


class Interrupted(BaseException):
    """A request to stop during a set-up that nothing depends on yet."""


class StopFlag:
    """Whether the process is requested to stop.

    Attributes:
        requested: whether it is.
        urgent: whether there was a second request: then the shortest way to stop is taken.
    """

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self.requested = False
        self.urgent = False
        self._now = now
        self._first = self._begin = self._patience = 0.0
        self._interruptible = False

    def request(self) -> None:
        """Request the end; a second time: the shortest way to it.

        Raises:
            Interrupted: the process is within `interruptible`.
        """
        now = self._now()
        if not self.requested:
            self.requested, self._first = True, now
        elif now - self._first >= _AGAIN:
            self.urgent = True
        self.interrupt()

    def interrupt(self) -> None:
        """End a part of the program that is `interruptible`, where it is in one and its patience is over.

        Raises:
            Interrupted: it is.
        """
        if self._interruptible and self._now() >= max(self._first, self._begin) + self._patience:
            raise Interrupted

    def heed(self) -> None:
        """End a part of the program that calls this between its steps, where the end is requested.

        Raises:
            Interrupted: it is.
        """
        if self.requested:
            raise Interrupted

    @contextmanager
    def interruptible(self, patience: float = 0.0) -> Iterator[None]:
        """A part of the program that a request ends at once; `stop_on_signals` ends with it.

        One within another has its own patience, and the outer one has all of its own again after it.

        Args:
            patience: time [s] that the part has to end by itself, after the request and its own begin.

        Raises:
            Interrupted: a request, also one from before.
        """
        if self.requested and patience == 0.0:
            raise Interrupted
        outer = self._patience, self._interruptible
        self._begin, self._patience, self._interruptible = self._now(), patience, True
        try:
            yield
        finally:
            self._begin = self._now()
            self._patience, self._interruptible = outer


@contextmanager
def stop_on_signals() -> Iterator[StopFlag]:
    """A flag that the signals above raise; the old handlers are restored afterwards.

    An exception that a handler raises is lost where it interrupts a callback of the compiler, so that
    `Interrupted` is raised again and again until the part that is interruptible has ended, and what was lost
    is not printed. The same repetition ends a part whose patience is over.
    """
    flag, report = StopFlag(), sys.unraisablehook

    def report_others(lost: sys.UnraisableHookArgs) -> None:
        if lost.exc_type is not Interrupted:
            report(lost)

    def handler(_signal: int, _frame: FrameType | None) -> None:
        signal.setitimer(signal.ITIMER_REAL, _AGAIN, _AGAIN)
        flag.request()

    def again(_signal: int, _frame: FrameType | None) -> None:
        flag.interrupt()

    ignored = signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    numbers = [number for number in _SIGNALS if not (ignored and number is signal.SIGHUP)]
    old = {number: signal.signal(number, handler) for number in numbers}
    old[signal.SIGALRM] = signal.signal(signal.SIGALRM, again)
    sys.unraisablehook = report_others
    try:
        with suppress(Interrupted):
            yield flag
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        sys.unraisablehook = report
        for number, before in old.items():
            signal.signal(number, before)
