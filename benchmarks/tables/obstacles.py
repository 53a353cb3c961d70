"""The numbers of `python -m benchmarks obstacles` as a table."""

from __future__ import annotations

from benchmarks.steps import DistanceBench
from tauten.service.tables import Numbers, Page, measured_on


def obstacles_page(result: DistanceBench) -> Page:
    """The table."""
    rows = tuple(
        (f"{one.in_range}", f"{one.median:.3f}", f"{one.p99:.3f}", f"{one.least:.3f}")
        for one in result.runs
    )
    title = (
        f"distances of {result.candidates} candidates to {result.triangles} triangles, whose tree takes "
        f"{result.build:.0f} ms to make"
    )
    table = Numbers(title, ("in range", "median [ms]", "p99 [ms]", "least [ms]"), rows)
    return Page(
        "python -m benchmarks obstacles", f"Measured on {measured_on(result.machine)}", (table,)
    )
