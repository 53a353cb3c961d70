"""The numbers of `tauten bench qpcc` as tables, for the terminal and for the docs."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from rich.table import Table

from tauten.service.bench_qpcc import QpccBench
from tauten.service.files import write_text
from tauten.service.qpcc_quality import Quality
from tauten.service.qpcc_times import SolveTimes
from tauten.service.report import Spread

BEGIN, END = "<!-- tauten bench qpcc -->", "<!-- end -->"
COMPARED = ((1, 5), (3, 10), (9, 23), (9, 40))  # cables and modes at which libraries are compared


@dataclass(frozen=True, slots=True)
class Numbers:
    """A table.

    Attributes:
        title: what it is about.
        columns: their names; the first is text, the others numbers.
        rows: cells.
    """

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    def rich(self) -> Table:
        """For the terminal."""
        table = Table(title=self.title)
        for index, name in enumerate(self.columns):
            table.add_column(name, justify="right" if index else "left")
        for row in self.rows:
            table.add_row(*row)
        return table

    def markdown(self) -> str:
        """For the docs."""
        rule = [":--", *["--:"] * (len(self.columns) - 1)]
        lines = [" | ".join(row) for row in (self.columns, rule, *self.rows)]
        return f"**{self.title}**\n\n" + "\n".join(f"| {line} |" for line in lines) + "\n"


def tables(result: QpccBench) -> tuple[Numbers, ...]:
    """All tables."""
    default = result.times[0].solver
    return (
        sizes_table([one for one in result.times if one.solver == default], default),
        libraries_table(result.times),
        gaps_table(result.quality),
        residuals_table(result.quality),
    )


def sizes_table(times: Iterable[SolveTimes], solver: str) -> Numbers:
    """Times and pivots of the default library by size."""
    rows: dict[tuple[int, int], list[str]] = {}
    for one in times:
        row = rows.setdefault((one.n_a, one.k), [f"{one.n_a} x {one.k}"])
        row += [milliseconds(one.ms), f"{one.pivots.p50:.0f} / {one.pivots.max:.0f}"]
    columns = ("cables x modes", "cold [ms]", "pivots", "warm [ms]", "pivots")
    title = f"Time (median / 99 %) and pivots (median / most) with {solver}"
    return Numbers(title, columns, tuple(map(tuple, rows.values())))


def libraries_table(times: tuple[SolveTimes, ...]) -> Numbers:
    """Times of all libraries at some sizes."""
    rows: dict[str, list[str]] = {}
    columns: dict[str, None] = {}
    for one in times:
        if (one.n_a, one.k) in COMPARED:
            columns[f"{one.n_a} x {one.k} {one.start}"] = None
            rows.setdefault(one.solver, [one.solver]).append(f"{one.ms.p50:.2f}")
    title = "QP libraries, median in ms"
    return Numbers(title, ("library", *columns), tuple(map(tuple, rows.values())))


def gaps_table(quality: Iterable[Quality]) -> Numbers:
    """How near the optimum solutions are."""
    rows = []
    for one in quality:
        for gaps in one.gaps:
            worst = "not solved" if gaps.worst is None else f"{100.0 * gaps.worst:.3g} %"
            proved = f"{100.0 * gaps.proved:.1f} %" if gaps.start == "second phase" else "-"
            problems = str(one.problems - one.empty)
            exact, percent = f"{100.0 * gaps.exact:.1f} %", f"{100.0 * gaps.percent:.1f} %"
            rows.append((one.name, gaps.start, problems, exact, percent, worst, proved))
    columns = ("problems", "start", "number", "within 1e-6", "within 1 %", "worst", "proved")
    return Numbers("Objectives above the global optimum", columns, tuple(rows))


def residuals_table(quality: Iterable[Quality]) -> Numbers:
    """Certificates, and comparison with staying."""
    rows = []
    for one in quality:
        stay = f"{one.worse_than_staying} of {one.stay}" if one.stay else "-"
        numbers = (f"{one.residual:.1e}", f"{one.judged:.1e}", f"{100.0 * one.strong:.1f} %")
        rows.append((one.name, *numbers, stay, str(one.empty), str(one.unproved)))
    columns = ("problems", "own", "judged", "strong", "worse than staying", "empty", "open")
    return Numbers("Largest residuals, and what else was checked", columns, tuple(rows))


def milliseconds(spread: Spread) -> str:
    """Median and 99th percentile."""
    return f"{spread.p50:.3f} / {spread.p99:.3f}"


def write_markdown(result: QpccBench, path: Path) -> None:
    """Put the tables between the marks of a page.

    Raises:
        ValueError: the page has no such marks.
        OSError: it cannot be read or written.
    """
    machine = result.machine
    measured = f"Measured on {machine.cores} x {machine.processor}, load {machine.load:.1f}."
    body = "\n".join([measured, "", *(table.markdown() for table in tables(result))])
    put_between(path, BEGIN, END, body)


def put_between(path: Path, begin: str, end: str, body: str) -> None:
    """Replace what is between two marks of a page.

    Raises:
        ValueError: the page has no such marks.
        OSError: it cannot be read or written.
    """
    head, found, rest = path.read_text(encoding="utf-8").partition(begin)
    _, closed, tail = rest.partition(end)
    if not (found and closed):
        raise ValueError(f"{path}: no place for the tables, which go between {begin} and {end}")
    write_text(path, f"{head}{begin}\n{body}{end}{tail}")
