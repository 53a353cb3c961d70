"""A run read back from its log, reported, and replayed."""

from tauten.service.replay.distance import Distances, distance_rows, measure_distances
from tauten.service.replay.recorded_setup import recorded_setup
from tauten.service.replay.replay_report import write_report
from tauten.service.replay.replaying import (
    CHANGED,
    Replay,
    actions,
    changes,
    has_changed,
    recorded_ticks,
    replay,
    replay_loop,
    write_problem,
)
from tauten.service.replay.report import (
    FOLLOWED,
    RunReport,
    Spread,
    apart,
    errors_to_goal,
    make_report,
    not_followed,
    overheads,
    spread,
    table_rows,
)
from tauten.service.replay.run import RecordedRun, Series, read_run

__all__ = [
    "CHANGED",
    "Distances",
    "FOLLOWED",
    "RecordedRun",
    "Replay",
    "RunReport",
    "Series",
    "Spread",
    "actions",
    "apart",
    "changes",
    "has_changed",
    "distance_rows",
    "errors_to_goal",
    "make_report",
    "measure_distances",
    "not_followed",
    "overheads",
    "read_run",
    "recorded_setup",
    "recorded_ticks",
    "replay",
    "replay_loop",
    "spread",
    "table_rows",
    "write_problem",
    "write_report",
]
