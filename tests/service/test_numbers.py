"""Tables of numbers on the terminal."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest
from support.processes import run_main

from tauten.service.cli.terminal import show_result
from tauten.service.tables import Numbers, Page, PageError


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


@contextmanager
def unread() -> Iterator[None]:
    """A pipe as stdout that nobody reads, as before `head` that has ended."""
    reader, writer = os.pipe()
    os.close(reader)
    with (
        suppress(BrokenPipeError),  # of what is left when it is closed
        os.fdopen(writer, "w") as pipe,
        pytest.MonkeyPatch.context() as patch,
    ):
        patch.setattr(sys, "stdout", pipe)
        yield


@pytest.mark.parametrize("arguments", [("kernels",), ("--version",), ("bench", "--help")])
def test_a_pipe_that_nobody_reads_is_no_finding(arguments: tuple[str, ...]) -> None:
    """It was exit code 1, which says of `check`, `solve` and `alive` what they have found."""
    with unread():
        assert run_main(*arguments) == 141


def test_numbers_are_written_also_where_nobody_reads_the_table(tmp_path: Path) -> None:
    """The command ended with the first line of the table, before."""
    with unread(), pytest.raises(SystemExit):
        show_result({"a": 1}, Page("tauten bench", "on a machine", ()), tmp_path / "numbers.json")
    assert (tmp_path / "numbers.json").is_file()


def test_the_table_is_shown_also_where_it_cannot_be_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "page.md").write_text("no marks")
    with pytest.raises(PageError, match="no marks"):
        show_result({}, Page("tauten bench", "on a machine", ()), None, tmp_path / "page.md")
    assert "on a machine" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("command", "option"),
    [
        (("bench", "node"), "--json"),
        (("bench", "node"), "--markdown"),
        (("reduce",), "--out"),
        (("replay",), "--problem"),
        (("view", "--simulate"), "--export"),
    ],
)
def test_a_folder_is_refused_before_anything_is_computed(
    command: tuple[str, ...], option: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """What had been computed was lost."""
    assert run_main(*command, tmp_path / "none.toml", option, tmp_path) == 2
    assert option in capsys.readouterr().err
