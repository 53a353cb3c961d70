"""Quadratic programs with complementarity constraints: problem, solver, certificate."""

from tauten.controller.qpcc.descent import Budget, Descent, DescentPoint, solve_piece
from tauten.controller.qpcc.homotopy import relaxation
from tauten.controller.qpcc.piece import parabola
from tauten.controller.qpcc.problem import Qpcc, Start, read_qpcc, write_qpcc
from tauten.controller.qpcc.qp import (
    UNBOUNDED,
    Backend,
    KeptQp,
    Qp,
    QpAnswer,
    available_backends,
    qp_backend,
    solve_daqp,
)
from tauten.controller.qpcc.relaxing import Solve, solve_relaxed
from tauten.controller.qpcc.residuals import certify
from tauten.controller.qpcc.scaling import USABLE, Scaled, scale
from tauten.controller.qpcc.solution import Certificate, Solution, Status
from tauten.controller.qpcc.solve import NO_PIECE, QpccSettings, solve_qpcc
from tauten.controller.qpcc.time_limit import TimeLimit
from tauten.controller.qpcc.warming import warm_solver

__all__ = [
    "Backend",
    "Budget",
    "Certificate",
    "Descent",
    "DescentPoint",
    "KeptQp",
    "NO_PIECE",
    "Qp",
    "QpAnswer",
    "Qpcc",
    "QpccSettings",
    "Scaled",
    "Solution",
    "Solve",
    "Start",
    "Status",
    "UNBOUNDED",
    "USABLE",
    "TimeLimit",
    "available_backends",
    "certify",
    "parabola",
    "qp_backend",
    "read_qpcc",
    "relaxation",
    "scale",
    "solve_daqp",
    "solve_piece",
    "solve_qpcc",
    "solve_relaxed",
    "warm_solver",
    "write_qpcc",
]
