"""The numbers of `tauten bench node` as a table, for the terminal and for the docs."""

from __future__ import annotations

from collections.abc import Sequence

from tauten.service.bench import Deadlines, NodeBench
from tauten.service.tables.numbers import Numbers, Page, measured_on, milliseconds


def node_page(results: Sequence[NodeBench]) -> Page:
    """The node at each rate, and a loop that does nothing as long."""
    first = results[0]
    columns = (
        "loop", "ticks", "missed", "skipped", "decide", "step", "the rest", "begins late",
        "target to actuation", "processor",
    )  # fmt: skip
    title = f"{first.robot}, model {first.model}: median / 99 % in ms"
    table = Numbers(title, columns, tuple(row for result in results for row in rows(result)))
    about = (
        f"{first.seconds:g} s at each rate, {first.target_rate_hz:g} targets a second. "
        f"Measured on {measured_on(first.machine)}"
    )
    return Page("tauten bench node", about, (table,))


def rows(result: NodeBench) -> list[tuple[str, ...]]:
    """The node at one rate, its viewer where there was one, and the loop beside it."""
    spreads = (
        result.decide_ms,
        result.step_ms,
        result.overhead_ms,
        result.lateness_ms,
        result.latency_ms,
    )
    times = (milliseconds(spread) for spread in spreads)
    none = ("",) * len(spreads)
    name = f"node, {result.rate_hz:g} Hz"
    found = [(name, *counts(result.deadlines), *times, share(result.processor_share))]
    if result.surfaces_hz:
        viewer = f"viewer, {result.surfaces_hz:.0f} surfaces a second"
        found.append((viewer, "", "", "", *none, share(result.viewer_share)))
    return [*found, ("busy with nothing", *counts(result.idle), *none, "")]


def share(value: float) -> str:
    """A share in percent."""
    return f"{100.0 * value:.1f} %" if value == value else "-"


def counts(deadlines: Deadlines) -> tuple[str, str, str]:
    """Ticks, missed ones and their share, skipped ones."""
    missed = f"{deadlines.missed:,} ({100.0 * deadlines.share:.2f} %)"
    return f"{deadlines.ticks:,}", missed, f"{deadlines.skipped:,}"
