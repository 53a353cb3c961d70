"""Plans: the QPCC (T1) over the horizon, posed, solved and checked."""

from tauten.controller.planning.course import shares_that_go_on, time_behind, with_goal
from tauten.controller.planning.energy import closed_compliance, energy_scale
from tauten.controller.planning.exact import missed_rows, with_exact_rows
from tauten.controller.planning.horizon import (
    Horizon,
    held_taut,
    horizon_of,
    largest_share,
    meets_contact,
    step_ahead,
)
from tauten.controller.planning.inverse import Aim, inverse_problem, position_names
from tauten.controller.planning.locks import (
    LockError,
    ahead_of_locks,
    locked,
    locks_of_step,
    no_locks,
    resting,
    unlocked,
    with_locks,
)
from tauten.controller.planning.plan import Plan
from tauten.controller.planning.posing import distance_left
from tauten.controller.planning.prepared import Prepared, Situation, prepared_plans
from tauten.controller.planning.seeking import brings_nearer, make_plan
from tauten.controller.planning.settings import FRICTION_SHARE, DecideSettings

__all__ = [
    "ahead_of_locks",
    "Aim",
    "brings_nearer",
    "closed_compliance",
    "DecideSettings",
    "distance_left",
    "energy_scale",
    "FRICTION_SHARE",
    "held_taut",
    "Horizon",
    "horizon_of",
    "inverse_problem",
    "largest_share",
    "locked",
    "LockError",
    "locks_of_step",
    "make_plan",
    "meets_contact",
    "missed_rows",
    "no_locks",
    "Plan",
    "position_names",
    "Prepared",
    "prepared_plans",
    "resting",
    "shares_that_go_on",
    "Situation",
    "step_ahead",
    "time_behind",
    "unlocked",
    "with_exact_rows",
    "with_goal",
    "with_locks",
]
