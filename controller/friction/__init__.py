"""Inverse control with exact Coulomb friction: problem and solver."""

from tauten.controller.friction.planned import MET, CutPlan, PlanContacts, PlanSearch
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
    "PlanContacts",
    "PlanSearch",
    "normals_alone",
    "solve_friction_inverse",
    "warm_search",
    "with_slip",
]
