"""Moved to `tauten.controller.qpcc`."""

from tauten.controller.qpcc.solution import Certificate, Solution, Status

__all__ = ["Certificate", "Solution", "Status"]
