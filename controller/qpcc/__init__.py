"""Quadratic programs with complementarity constraints: problem, solver, certificate."""

from tauten.controller.qpcc.certificate import certify
from tauten.controller.qpcc.descent import Descent, Point, solve_piece
from tauten.controller.qpcc.elastic import least_violation
from tauten.controller.qpcc.elimination import back_substitute, eliminate, solve_transposed
from tauten.controller.qpcc.lcp_start import feasible_start, solve_lcp
from tauten.controller.qpcc.one_cable import parabola, within_limit
from tauten.controller.qpcc.problem import Qpcc, Start
from tauten.controller.qpcc.qp import (
    UNBOUNDED,
    Qp,
    QpAnswer,
    RepeatedQp,
    available_backends,
    qp_backend,
    solve_daqp,
)
from tauten.controller.qpcc.qp_bound import lower_bound
from tauten.controller.qpcc.qp_polish import polished
from tauten.controller.qpcc.residuals import judge
from tauten.controller.qpcc.scaling import USABLE, Scaled, scale
from tauten.controller.qpcc.solution import Certificate, Solution, Status
from tauten.controller.qpcc.solve import QpccSettings, solve_qpcc
from tauten.controller.qpcc.warming import warm_solver

__all__ = [
    "Certificate",
    "Descent",
    "Point",
    "Qp",
    "QpAnswer",
    "Qpcc",
    "QpccSettings",
    "RepeatedQp",
    "Scaled",
    "Solution",
    "Start",
    "Status",
    "UNBOUNDED",
    "USABLE",
    "available_backends",
    "back_substitute",
    "certify",
    "eliminate",
    "feasible_start",
    "judge",
    "least_violation",
    "lower_bound",
    "parabola",
    "polished",
    "qp_backend",
    "scale",
    "solve_daqp",
    "solve_lcp",
    "solve_piece",
    "solve_qpcc",
    "solve_transposed",
    "warm_solver",
    "within_limit",
]
