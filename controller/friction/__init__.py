"""Inverse control with exact Coulomb friction: problem and solver."""

from tauten.controller.friction.problem import FrictionInverse
from tauten.controller.friction.solve import (
    FrictionSettings,
    InverseSolution,
    solve_friction_inverse,
)

__all__ = [
    "FrictionInverse",
    "FrictionSettings",
    "InverseSolution",
    "solve_friction_inverse",
]
