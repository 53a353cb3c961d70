"""Tables of numbers on the terminal."""

from __future__ import annotations

import pytest

from tauten.service.cli.terminal import show_result
from tauten.service.tables import Numbers, Page


def test_brackets_are_printed_as_they_are(capsys: pytest.CaptureFixture[str]) -> None:
    table = Numbers("way [mm]", ("case", "settled [s]"), (("step [1]", "0.68"),))
    show_result({}, Page("tauten bench", "on a machine", (table,)), None)
    printed = capsys.readouterr().out
    for text in ("way [mm]", "settled [s]", "step [1]"):
        assert text in printed
    assert "\\" not in printed
