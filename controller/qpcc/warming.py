"""Every way through `solve_qpcc` taken once: a kernel that is first needed in a loop stops it for seconds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tauten.controller.qpcc.descent import Budget, Descent, solve_piece
from tauten.controller.qpcc.problem import Qpcc
from tauten.controller.qpcc.qp import Backend, qp_backend
from tauten.controller.qpcc.scaling import scale
from tauten.controller.qpcc.solve import QpccSettings, solve_qpcc
from tauten.controller.qpcc.time_limit import TimeLimit

CLOSED = np.zeros(2, dtype=np.bool_)


def warm_solver(solver: str | Backend) -> None:
    """Compile or load all kernels of `solve_qpcc`, those of its rare ways too.

    Rare are degenerate points, and limits in conflict.

    Args:
        solver: QP library, see `qp.qp_backend`.

    Raises:
        ValueError: the library is not installed.
    """
    backend = qp_backend(solver)
    settings = QpccSettings(solver, second_start="always")
    for n_a in (1, 2):  # one tension has kernels of its own
        problem = small(n_a)
        solve_qpcc(problem, settings=settings)
        solve_qpcc(problem, CLOSED, replace(settings, second_start="never"))
        solve_qpcc(replace(problem, g_lo=np.array([9.0]), g_hi=np.array([9.5])), settings=settings)
        _, scaled, _ = scale(problem)
        descent = Descent(scaled, backend, Budget(8, TimeLimit(9.0)))
        point = solve_piece(scaled, CLOSED, backend)
        if point is not None:
            descent.settle(point)


def small(n_a: int) -> Qpcc:
    """Cables n_a and two contacts that push each other, both closed at the start without pushing."""
    n = n_a + 2
    M = np.hstack([-np.ones((2, n_a)), np.array([[1.0, 0.5], [0.5, 1.0]])])
    return Qpcc(
        Q=np.eye(n), c=-np.ones(n), lb=np.zeros(n_a), ub=np.ones(n_a),
        G=np.ones((1, n)), g_lo=np.array([-1.0]), g_hi=np.array([2.0]),
        M=M, m=np.zeros(2),
    )  # fmt: skip
