"""What commands say while they work."""

from __future__ import annotations

import logging

import pytest

from tauten.service.cli.terminal import progress_bar


def test_without_a_terminal_lines_of_the_log_say_how_far_it_is(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """Twice a minute, of what is done by then."""
    now = 0.0
    monkeypatch.setattr("time.monotonic", lambda: now)
    with caplog.at_level(logging.INFO), progress_bar("contact modes") as report:
        for second in range(100):
            now = float(second)
            report(0.01, "k = 3" if second == 60 else "")
    assert [record.message for record in caplog.records] == [
        "contact modes: 31 %", "k = 3: 61 %", "contact modes: 91 %",
    ]  # fmt: skip
