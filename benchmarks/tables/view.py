"""The numbers of `python -m benchmarks view` as a table, for the terminal and for the docs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from tauten.service.tables import Numbers, Page, measured_on, milliseconds

if TYPE_CHECKING:
    from benchmarks.view import ViewCost


def view_page(costs: Sequence[ViewCost]) -> Page:
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
    table = Numbers("The viewer, without what moves the robot", columns, rows)
    about = f"{costs[0].seconds:.0f} s each. Measured on {measured_on(costs[0].machine)}"
    return Page("python -m benchmarks view", about, (table,))
