"""Contact with exact Coulomb friction: the problem, its solver and its certificate."""

from tauten.model.friction.certificate import PROJECTIONS, FrictionCertificate, certify_friction
from tauten.model.friction.padded_rows import moving_contacts, padded_places, padded_rows
from tauten.model.friction.problem import FrictionProblem, natural_error
from tauten.model.friction.proximal_newton import (
    Cones,
    NewtonForces,
    error_of,
    newton_forces,
    solve_friction,
)

__all__ = [
    "Cones",
    "FrictionCertificate",
    "FrictionProblem",
    "NewtonForces",
    "PROJECTIONS",
    "certify_friction",
    "error_of",
    "moving_contacts",
    "natural_error",
    "newton_forces",
    "padded_places",
    "padded_rows",
    "solve_friction",
]
