"""Tables of numbers, for the terminal and for pages of the docs."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from rich.markup import escape
from rich.table import Table

from tauten.service.process import HostInfo, write_text
from tauten.service.replay import Spread


class PageError(ValueError):
    """A page that tables cannot be put into; the message names what is missing."""


@dataclass(frozen=True, slots=True)
class Numbers:
    """A table.

    Attributes:
        title: what it is about; "" for none.
        columns: their names.
        rows: cells.
        text_columns: how many of the first columns are text, the others are numbers.
    """

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    text_columns: int = 1

    def rich(self) -> Table:
        """For the terminal."""
        table = Table(title=escape(self.title))
        for index, name in enumerate(self.columns):
            table.add_column(
                escape(name), justify="right" if index >= self.text_columns else "left"
            )
        for row in self.rows:
            table.add_row(*map(escape, row))
        return table

    def markdown(self) -> str:
        """For the docs."""
        text = self.text_columns
        rule = [":--"] * text + ["--:"] * (len(self.columns) - text)
        lines = [" | ".join(row) for row in (self.columns, rule, *self.rows)]
        title = f"**{self.title}**\n\n" if self.title else ""
        return title + "\n".join(f"| {line} |" for line in lines) + "\n"


def milliseconds(spread: Spread) -> str:
    """Median and 99th percentile; a dash where nothing was measured."""
    if spread.p50 is None:
        return "-"
    return f"{spread.p50:.3f} / {spread.p99:.3f}"


def percent(share: float | None) -> str:
    """A relative error; a dash where there is none."""
    return "-" if share is None else f"{100.0 * share:+.1f} %"


def millimetres(length: float | None) -> str:
    """A distance; a dash where there is none."""
    return "-" if length is None else f"{1e3 * length:.2f}"


def measured_on(machine: HostInfo) -> str:
    """The machine that times were taken on, and how busy it was."""
    return f"{machine.cores} x {machine.processor}, load {machine.load:.1f}."


def put_tables(path: Path, begin: str, end: str, about: str, tables: Iterable[Numbers]) -> None:
    """Write a line and tables between two marks of a page.

    Args:
        path: the page, a Markdown file.
        begin: mark before the tables.
        end: mark after them.
        about: the line above the tables.
        tables: in their order.

    Raises:
        PageError: the page has no such marks.
        OSError: it cannot be read or written.
    """
    put_between(path, begin, end, "\n".join([about, "", *(table.markdown() for table in tables)]))


def put_between(path: Path, begin: str, end: str, body: str) -> None:
    """Replace the text between two marks of a page.

    Args:
        path: the page.
        begin: mark before the text.
        end: mark after it.
        body: the new text.

    Raises:
        PageError: the page has no such marks.
        OSError: it cannot be read or written.
    """
    head, found, rest = path.read_text(encoding="utf-8").partition(begin)
    _, closed, tail = rest.partition(end)
    if not (found and closed):
        raise PageError(f"{path}: has no marks {begin} and {end} for the tables")
    write_text(path, f"{head}{begin}\n{body}{end}{tail}")
