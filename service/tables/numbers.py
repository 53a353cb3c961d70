"""Tables of numbers, for the terminal and for pages of the docs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from rich.console import JustifyMethod
from rich.table import Table
from rich.text import Text

from tauten.reduction import write_text
from tauten.service.process import HostInfo
from tauten.service.replay import Spread

LONGEST = 24  # characters of a word; longer ones, as paths, are wrapped


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

    def rich(self, width: int) -> Table:
        """For a terminal; where the columns do not fit, a column of names and one of values.

        Numbers are never cut.
        """
        title = Text(self.title, "table.title")
        if self.least_width > width:
            table = Table("", "", title=title, show_header=False)
            for row in self.rows:
                for name, value in zip(self.columns, row, strict=True):
                    table.add_row(Text(name), Text(value))
                table.add_section()
            return table
        table = Table(title=title)
        for index, name in enumerate(self.columns):
            justify: JustifyMethod = "right" if index >= self.text_columns else "left"
            table.add_column(Text(name), justify=justify, min_width=self.widths[index])
        for row in self.rows:
            table.add_row(*map(Text, row))
        return table

    @property
    def widths(self) -> tuple[int, ...]:
        """Least width of each column: no word of a text is cut, no number is wrapped."""
        found = []
        for index, name in enumerate(self.columns):
            cells = [row[index] for row in self.rows]
            if index < self.text_columns:
                cells = [word for cell in cells for word in cell.split()]
                cells = [cell[:LONGEST] for cell in cells]
            found.append(max((len(one) for one in (*cells, *name.split())), default=0))
        return tuple(found)

    @property
    def least_width(self) -> int:
        """Of the table with its lines."""
        return sum(self.widths) + 3 * len(self.columns) + 1

    def markdown(self) -> str:
        """For the docs."""
        text = self.text_columns
        rule = [":--"] * text + ["--:"] * (len(self.columns) - text)
        lines = [" | ".join(row) for row in (self.columns, rule, *self.rows)]
        title = f"**{self.title}**\n\n" if self.title else ""
        return title + "\n".join(f"| {line} |" for line in lines) + "\n"


@dataclass(frozen=True, slots=True)
class Page:
    """A result as it is shown: on the terminal, and between two marks of a page.

    Attributes:
        command: that the result is of, as it is typed; the mark in the page names it.
        about: what was measured, where.
        parts: tables, and sentences between them.
    """

    command: str
    about: str
    parts: tuple[Numbers | str, ...]

    @property
    def tables(self) -> tuple[Numbers, ...]:
        """Those of the parts that are tables."""
        return tuple(part for part in self.parts if isinstance(part, Numbers))

    def markdown(self) -> str:
        """The line about the result, and the parts in their order."""
        parts = [part if isinstance(part, str) else part.markdown() for part in self.parts]
        return "\n\n".join(part.strip() for part in (self.about, *parts) if part) + "\n"

    def put_into(self, path: Path) -> None:
        """Write the result between the marks of a page, a Markdown file.

        Raises:
            PageError: the page has no such marks.
            OSError: it cannot be read or written.
        """
        begin, end = f"<!-- {self.command} -->", "<!-- end -->"
        head, found, rest = path.read_text(encoding="utf-8").partition(begin)
        _, closed, tail = rest.partition(end)
        if not (found and closed):
            raise PageError(f"{path}: has no marks {begin} and {end} for the tables")
        write_text(path, f"{head}{begin}\n{self.markdown()}{end}{tail}")


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
