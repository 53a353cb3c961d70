"""Inverse control with exact Coulomb friction: problem and solver."""

from tauten.controller.friction.problem import FrictionInverse
from tauten.controller.friction.solve import (
    FrictionSettings,
    InverseSolution,
    as_solution,
    solve_friction_inverse,
)

__all__ = [
    "FrictionInverse",
    "FrictionSettings",
    "InverseSolution",
    "as_solution",
    "solve_friction_inverse",
]
