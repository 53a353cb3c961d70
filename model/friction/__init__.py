"""Contact with exact Coulomb friction: the problem, its solver and its certificate."""

from tauten.model.friction.certificate import FrictionCertificate, certify_friction
from tauten.model.friction.problem import FrictionProblem
from tauten.model.friction.proximal_newton import solve_friction

__all__ = [
    "FrictionCertificate",
    "FrictionProblem",
    "certify_friction",
    "solve_friction",
]
