"""The numbers of `tauten bench node` as a table, for the terminal and for the docs."""

from __future__ import annotations

from pathlib import Path

from tauten.service.bench_node import Deadlines, NodeBench
from tauten.service.tables import Numbers, measured_on, milliseconds, put_tables

BEGIN, END = "<!-- tauten bench node -->", "<!-- end -->"


def table(result: NodeBench) -> Numbers:
    """The node, and a loop that does nothing as long."""
    title = f"{result.robot} at {result.rate_hz:g} Hz, model {result.model}: median / 99 % in ms"
    spreads = (
        result.decide_ms,
        result.step_ms,
        result.overhead_ms,
        result.lateness_ms,
        result.latency_ms,
    )
    columns = (
        "loop", "ticks", "missed", "skipped", "decide", "step", "the rest", "begins late",
        "target to actuation",
    )  # fmt: skip
    node = ("node", *counts(result.deadlines), *(milliseconds(spread) for spread in spreads))
    idle = ("busy with nothing", *counts(result.idle), *("" for _ in spreads))
    return Numbers(title, columns, (node, idle))


def counts(deadlines: Deadlines) -> tuple[str, str, str]:
    """Ticks, missed ones and their share, skipped ones."""
    share = f"{deadlines.missed:,} ({100.0 * deadlines.share:.2f} %)"
    return f"{deadlines.ticks:,}", share, f"{deadlines.skipped:,}"


def write_markdown(result: NodeBench, path: Path) -> None:
    """Put the table into a page, see `put_tables`."""
    about = (
        f"{result.seconds:g} s, {result.target_rate_hz:g} targets a second. "
        f"Measured on {measured_on(result.machine)}"
    )
    put_tables(path, BEGIN, END, about, [table(result)])
