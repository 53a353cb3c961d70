"""Ctrl-C while the mesher's process is only starting: it ends nevertheless."""

from __future__ import annotations

import signal
import subprocess
import time
from pathlib import Path
from types import FrameType

import pytest

from tauten.service.new import meshing


class Stopped(BaseException):
    """What the handler of a signal raises."""


def test_a_mesher_that_is_only_starting_is_ended(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    started: list[subprocess.Popen[str]] = []

    class Slow(subprocess.Popen):  # type: ignore[type-arg]
        def __init__(self, _command: list[str], **settings: object) -> None:
            super().__init__(["sleep", "60"], **settings)  # type: ignore[call-overload]
            started.append(self)
            time.sleep(0.4)

    def stopped(_signal: int, _frame: FrameType | None) -> None:
        raise Stopped

    monkeypatch.setattr(meshing.subprocess, "Popen", Slow)
    before = signal.signal(signal.SIGALRM, stopped)
    signal.setitimer(signal.ITIMER_REAL, 0.2)
    try:
        with pytest.raises(Stopped):
            meshing._run(["surface", "part.stl", "1", str(tmp_path / "out.npz")], tmp_path)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
    assert started[0].wait(10.0) == -signal.SIGKILL
