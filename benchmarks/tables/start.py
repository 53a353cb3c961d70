"""The numbers of `python -m benchmarks first-hour` as a table, for the terminal and for the docs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from tauten.service.tables import Numbers, Page, measured_on

if TYPE_CHECKING:
    from benchmarks.kernels import FirstHour

STARTS = {
    "cold": "nothing compiled, nothing shipped",
    "seeded": "with the kernels that are shipped",
    "warm": "a second time",
}


def first_hour_page(demos: Sequence[FirstHour]) -> Page:
    """How long the demo takes from each start."""
    columns = (
        "`tauten demo --seconds 5`",
        "first target followed [s]",
        "end [s]",
        "processor [s]",
        "compiled",
        "load",
    )
    rows = tuple(
        (
            STARTS[one.start],
            f"{one.first_tick:.1f}",
            f"{one.seconds:.1f}",
            f"{one.processor:.1f}",
            str(one.compiled),
            f"{one.machine.load:.1f}",
        )
        for one in demos
    )
    about = f"Measured on {measured_on(demos[-1].machine)}"
    return Page("python -m benchmarks first-hour", about, (Numbers("", columns, rows),))
