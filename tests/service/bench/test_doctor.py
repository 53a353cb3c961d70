"""What `tauten doctor` advises where a loop misses its deadlines."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import pytest

from tauten.service.bench import doctor
from tauten.service.setup import load_setup


@pytest.mark.long
@pytest.mark.parametrize(
    ("share", "advice"), [(0.01, "something else takes the time"), (2.0, "this machine holds 2")]
)
def test_late_ticks_are_those_of_the_step_or_of_something_else(
    beam_file: Path, monkeypatch: pytest.MonkeyPatch, share: float, advice: str
) -> None:
    """All ticks are late; a step takes a share of the period."""
    setup = load_setup(beam_file)
    tick = SimpleNamespace(lateness=0.0)
    late = SimpleNamespace(wait=lambda: tick, missed=1000)
    monkeypatch.setattr(doctor, "punctual_clock", lambda period: late)
    monkeypatch.setattr(doctor, "step_seconds", lambda controller: share * setup.robot.h)
    found = {finding.what: finding for finding in doctor._rate(setup, 0.0)}
    assert advice in found["rate, requested / achieved"].advice


@pytest.mark.long
def test_the_rate_does_not_count_the_time_before_the_loop(
    beam_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A collection of garbage took a tenth of a second: 47.5 Hz were achieved, and no tick missed."""
    usual = doctor.manual_garbage_collection

    @contextmanager
    def slow() -> Iterator[None]:
        time.sleep(0.6)
        with usual():
            yield

    monkeypatch.setattr(doctor, "manual_garbage_collection", slow)
    found = {finding.what: finding.found for finding in doctor._rate(load_setup(beam_file), 0.5)}
    assert int(found["deadlines missed / ticks"].split()[-1]) > 3
