"""Numbers as tables, for the terminal and for pages."""

from tauten.service.tables.basis import basis_tables, found_robot, kept_curve, origin_table
from tauten.service.tables.benches import (
    closed_loop_page,
    node_page,
    reduced_page,
    steps_page,
    tip_distance,
)
from tauten.service.tables.meshes import check_page, new_page
from tauten.service.tables.numbers import (
    Numbers,
    Page,
    PageError,
    measured_on,
    millimetres,
    milliseconds,
    percent,
)

__all__ = [
    "Numbers",
    "Page",
    "PageError",
    "basis_tables",
    "check_page",
    "closed_loop_page",
    "found_robot",
    "kept_curve",
    "measured_on",
    "millimetres",
    "milliseconds",
    "new_page",
    "origin_table",
    "node_page",
    "percent",
    "reduced_page",
    "steps_page",
    "tip_distance",
]
