"""A run read back from its log, reported, and replayed."""

from tauten.service.replay.replay_report import TICKS, VERDICT, write_report
from tauten.service.replay.replaying import Replay, replay, write_problem
from tauten.service.replay.report import (
    RunReport,
    Spread,
    distance_to_goal,
    make_report,
    overheads,
    spread,
    table_rows,
)
from tauten.service.replay.run import RecordedRun, Series, read_run

__all__ = [
    "RecordedRun",
    "Replay",
    "RunReport",
    "Series",
    "Spread",
    "TICKS",
    "VERDICT",
    "distance_to_goal",
    "make_report",
    "overheads",
    "read_run",
    "replay",
    "spread",
    "table_rows",
    "write_problem",
    "write_report",
]
