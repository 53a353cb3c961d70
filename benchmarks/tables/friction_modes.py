"""The numbers of `python -m benchmarks friction-modes` as a table."""

from __future__ import annotations

from benchmarks.friction import SharedModesBench
from tauten.service.tables import Numbers, Page, measured_on


def friction_modes_page(result: SharedModesBench) -> Page:
    """One table."""
    rows = tuple(
        (
            f"{one.robot}, {one.order}",
            f"{one.steps} / {one.pushing:.0f}",
            f"{one.modes:.0f}",
            f"{100 * one.lost:.0f}",
            f"{1e3 * one.depth:.2f} / {1e3 * one.natural:.2f}",
            f"{one.left:.0e}",
            "{:.0f} / {:.0f}".format(*one.columns),
            "{:.0f} / {:.0f}".format(*one.newton),
            "{:.2f} / {:.2f}".format(*one.ms),
        )
        for one in result.cases
    )
    columns = (
        *("robot", "steps / candidates that push", "modes", "effect lost [%]"),
        *("depth / natural map [mm]", "natural map with unit columns [m]"),
        *("unit columns", "Newton steps", "time [ms]"),
    )
    title = "modes that normal and tangential forces share; the last three without / with modes, medians"
    table = Numbers(title, columns, rows)
    return Page(
        "python -m benchmarks friction-modes",
        f"Measured on {measured_on(result.machine)}",
        (table,),
    )
