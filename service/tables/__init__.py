"""Numbers as tables, for the terminal and for pages."""

from tauten.service.tables.basis import basis_tables, found_robot, kept_curve, ranges
from tauten.service.tables.check import check_tables, write_check_tables
from tauten.service.tables.closed_loop import closed_loop_tables, write_closed_loop_tables
from tauten.service.tables.new_robot import trial_table
from tauten.service.tables.node import NODE_BEGIN, NODE_END, node_table, write_node_tables
from tauten.service.tables.numbers import (
    Numbers,
    PageError,
    measured_on,
    millimetres,
    milliseconds,
    percent,
    put_between,
    put_tables,
)
from tauten.service.tables.reduced import reduced_tables, write_reduced_tables
from tauten.service.tables.steps import steps_table
from tauten.service.tables.still import still_tables

__all__ = [
    "NODE_BEGIN",
    "NODE_END",
    "Numbers",
    "PageError",
    "basis_tables",
    "check_tables",
    "closed_loop_tables",
    "found_robot",
    "kept_curve",
    "measured_on",
    "millimetres",
    "milliseconds",
    "node_table",
    "percent",
    "put_between",
    "put_tables",
    "ranges",
    "reduced_tables",
    "steps_table",
    "still_tables",
    "trial_table",
    "write_check_tables",
    "write_closed_loop_tables",
    "write_node_tables",
    "write_reduced_tables",
]
