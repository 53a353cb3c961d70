"""Inverse control with exact Coulomb friction: problem and solver."""

from tauten.controller.friction.planned import (
    MET,
    CutPlan,
    PlanSearch,
    no_slots,
    pushed_slots,
    with_known_columns,
)
from tauten.controller.friction.problem import FrictionInverse, normals_alone
from tauten.controller.friction.slip import with_slip
from tauten.controller.friction.solve import (
    FrictionSettings,
    InverseSolution,
    solve_friction_inverse,
)
from tauten.controller.friction.trials import ALL_TRIED
from tauten.controller.friction.warming import warm_search

__all__ = [
    "ALL_TRIED",
    "MET",
    "CutPlan",
    "FrictionInverse",
    "FrictionSettings",
    "InverseSolution",
    "PlanSearch",
    "no_slots",
    "normals_alone",
    "pushed_slots",
    "solve_friction_inverse",
    "warm_search",
    "with_known_columns",
    "with_slip",
]
