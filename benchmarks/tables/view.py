"""The numbers of `python -m benchmarks view` as a table, for the terminal and for the docs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from tauten.service.tables import Numbers, measured_on, milliseconds, put_tables

if TYPE_CHECKING:
    from tauten.service.view import ViewCost

VIEW_BEGIN, VIEW_END = "<!-- python -m benchmarks view -->", "<!-- end -->"


def view_table(costs: Sequence[ViewCost]) -> Numbers:
    """What showing each robot costs."""
    columns = (
        "robot", "nodes", "vertices", "triangles", "pictures a second", "processor share",
        "time of a picture [ms]: median / 99 %",
    )  # fmt: skip
    rows = tuple(
        (
            cost.robot,
            f"{cost.nodes:,}",
            f"{cost.vertices:,}",
            f"{cost.triangles:,}",
            f"{cost.pictures_hz:.1f}",
            f"{100.0 * cost.processor_share:.1f} %",
            milliseconds(cost.picture_ms),
        )
        for cost in costs
    )
    return Numbers("The viewer, without what moves the robot", columns, rows)


def write_view_table(costs: Sequence[ViewCost], path: Path) -> None:
    """Put the table into a page, see `put_tables`."""
    first = costs[0]
    about = f"{first.seconds:.0f} s each. Measured on {measured_on(first.machine)}"
    put_tables(path, VIEW_BEGIN, VIEW_END, about, [view_table(costs)])
