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


@pytest.mark.parametrize("width", [40, 60, 80])
@pytest.mark.parametrize("columns", [2, 5, 9])
def test_numbers_are_never_cut(
    width: int, columns: int, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where its columns do not fit, a table has a column of names and one of values."""
    monkeypatch.setenv("COLUMNS", str(width))
    names = ("elements", *(f"largest error {i} [mm]" for i in range(1, columns)))
    numbers = [f"{1234.5678 + i:+.4f}" for i in range(1, columns)]
    table = Numbers("", names, (("smoothed, refined once", *numbers),))
    show_result({}, Page("tauten bench", "on a machine", (table,)), None)
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= width
    assert all(any(number in line for line in lines) for number in numbers)
