"""Inverse control with exact Coulomb friction: problem and solver."""

from tauten.controller.friction.planned import PlanContacts
from tauten.controller.friction.problem import FrictionInverse, normals_alone
from tauten.controller.friction.solve import (
    FrictionSettings,
    InverseSolution,
    solve_friction_inverse,
)
from tauten.controller.friction.warming import warm_search

__all__ = [
    "FrictionInverse",
    "FrictionSettings",
    "InverseSolution",
    "PlanContacts",
    "normals_alone",
    "solve_friction_inverse",
    "warm_search",
]
