"""Campaigns: designs of excitation, and the snapshots of the equilibria they cause."""

from tauten.reduction.campaign.chunk import MAX_ITERATIONS, TOLERANCE
from tauten.reduction.campaign.command_range import CommandRange, Report, command_range
from tauten.reduction.campaign.designs import (
    Design,
    DesignError,
    Ranges,
    Run,
    from_csv,
    latin_hypercube,
    latin_hypercube_levels,
    plackett_burman,
    plackett_burman_levels,
    ramp,
)
from tauten.reduction.campaign.executors import (
    ClusterError,
    dask_cluster,
    interrupts_blocked,
    processes,
)
from tauten.reduction.campaign.exploring import exploring, payload
from tauten.reduction.campaign.run import run_campaign
from tauten.reduction.campaign.snapshots import Origin, SnapshotError, Snapshots, join_snapshots
from tauten.reduction.campaign.touched import (
    PLACES,
    TouchedRobot,
    of_plain_robot,
    pressed_by,
    pressed_columns,
    touched_robot,
)
from tauten.reduction.campaign.within_limits import narrowed

__all__ = [
    "PLACES",
    "ClusterError",
    "CommandRange",
    "command_range",
    "Design",
    "DesignError",
    "MAX_ITERATIONS",
    "Origin",
    "Ranges",
    "Report",
    "Run",
    "SnapshotError",
    "Snapshots",
    "TOLERANCE",
    "TouchedRobot",
    "dask_cluster",
    "exploring",
    "from_csv",
    "interrupts_blocked",
    "join_snapshots",
    "latin_hypercube",
    "latin_hypercube_levels",
    "narrowed",
    "of_plain_robot",
    "payload",
    "plackett_burman",
    "plackett_burman_levels",
    "pressed_by",
    "pressed_columns",
    "processes",
    "ramp",
    "run_campaign",
    "touched_robot",
]
