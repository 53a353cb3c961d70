"""Numbers as tables, for the terminal and for pages."""

from tauten.service.tables.basis import basis_tables, found_robot, kept_curve, ranges
from tauten.service.tables.check import check_page
from tauten.service.tables.closed_loop import closed_loop_page
from tauten.service.tables.new_robot import trial_table
from tauten.service.tables.node import node_page
from tauten.service.tables.numbers import (
    Numbers,
    Page,
    PageError,
    measured_on,
    millimetres,
    milliseconds,
    percent,
)
from tauten.service.tables.reduced import reduced_page, tip_distance
from tauten.service.tables.steps import steps_page
from tauten.service.tables.still import still_page

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
    "node_page",
    "percent",
    "ranges",
    "reduced_page",
    "steps_page",
    "still_page",
    "tip_distance",
    "trial_table",
]
