"""A request to stop ends what is interruptible, also where its exception is lost."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import time

import pytest

from tauten.service.process import stop_on_signals

LONG = 20.0  # s, if nothing interrupts it


def test_a_request_that_is_lost_in_a_callback_comes_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """As in the compiler: an exception in a callback of C is ignored; that of a request is not printed."""
    lost, printed = list[bool](), list[object]()
    monkeypatch.setattr(sys, "unraisablehook", lambda one: printed.append(one.exc_type))

    def send() -> None:
        os.kill(os.getpid(), signal.SIGTERM)
        lost.append(False)  # not reached where the signal interrupts the callback

    begin = time.monotonic()
    with stop_on_signals() as stop, stop.interruptible():
        ctypes.CFUNCTYPE(None)(send)()
        lost.append(True)
        time.sleep(LONG)
    assert stop.requested
    assert lost == [True]
    assert printed == []
    assert time.monotonic() - begin < LONG


def test_other_exceptions_in_a_callback_are_printed(monkeypatch: pytest.MonkeyPatch) -> None:
    printed = list[object]()
    monkeypatch.setattr(sys, "unraisablehook", lambda one: printed.append(one.exc_type))
    before = sys.unraisablehook

    def fail() -> None:
        raise KeyError("x")

    with stop_on_signals():
        ctypes.CFUNCTYPE(None)(fail)()
    assert printed == [KeyError]
    assert sys.unraisablehook is before


def test_after_a_stop_no_alarm_is_left() -> None:
    before = signal.getsignal(signal.SIGALRM)
    with stop_on_signals() as stop:
        os.kill(os.getpid(), signal.SIGTERM)
    assert stop.requested
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)
    assert signal.getsignal(signal.SIGALRM) is before
