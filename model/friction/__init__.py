"""Contact with exact Coulomb friction: the problem, its solver and its certificate."""

from tauten.model.friction.certificate import PROJECTIONS, FrictionCertificate, certify_friction
from tauten.model.friction.padded_rows import moving_contacts, padded_places, padded_rows
from tauten.model.friction.problem import Cones, FrictionProblem, error_of, velocities
from tauten.model.friction.proximal_newton import NewtonForces, newton_forces, newton_round
from tauten.model.friction.smoothed_law import (
    LinearLaw,
    Widths,
    law_error,
    law_size,
    linear_law,
    smoothed_law,
    widths,
)
from tauten.model.friction.smoothed_path import Width, shortened, smoothed_forces
from tauten.model.friction.solve import solve_friction

__all__ = [
    "Cones",
    "FrictionCertificate",
    "FrictionProblem",
    "LinearLaw",
    "NewtonForces",
    "PROJECTIONS",
    "Width",
    "Widths",
    "certify_friction",
    "error_of",
    "law_error",
    "law_size",
    "linear_law",
    "moving_contacts",
    "newton_forces",
    "newton_round",
    "padded_places",
    "padded_rows",
    "shortened",
    "smoothed_forces",
    "smoothed_law",
    "solve_friction",
    "velocities",
    "widths",
]
