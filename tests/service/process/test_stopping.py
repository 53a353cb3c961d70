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


def test_a_part_may_end_by_itself_for_a_while() -> None:
    """A request does not end it at once, but it ends."""
    begin, woken = time.monotonic(), 0.0
    with stop_on_signals() as stop, stop.interruptible(0.6):
        signal.raise_signal(signal.SIGTERM)
        woken = time.monotonic() - begin
        time.sleep(LONG)
    assert stop.requested
    assert woken < 0.6 <= time.monotonic() - begin < LONG


def test_a_part_that_begins_after_the_request_has_its_own_time() -> None:
    """As the end of a robot's motion has."""
    reached = []
    with stop_on_signals() as stop:
        signal.raise_signal(signal.SIGTERM)
        with stop.interruptible(0.1):
            time.sleep(0.05)
            reached.append("own end")
        time.sleep(0.5)  # no part: nothing is interrupted
        with stop.interruptible(0.1):
            time.sleep(LONG)
        reached.append("not here")
    assert reached == ["own end"]


def test_a_part_within_another_has_its_own_patience() -> None:
    """And the outer one all of its own after it: no call of it lasts longer because of the inner one."""
    reached = []
    with stop_on_signals() as stop, stop.interruptible(0.3):
        with stop.interruptible(1.5):
            signal.raise_signal(signal.SIGTERM)
            time.sleep(1.0)
            reached.append("inner")
        time.sleep(0.1)
        reached.append("outer")
        time.sleep(LONG)
        reached.append("not here")
    assert reached == ["inner", "outer"]


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
