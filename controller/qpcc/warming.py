"""Every way through `solve_qpcc` taken once: a kernel that is first needed in a loop stops it for seconds."""

from __future__ import annotations

import numpy as np

from tauten.controller.qpcc.descent import Descent
from tauten.controller.qpcc.elastic import least_violation
from tauten.controller.qpcc.lcp_start import scaled_start
from tauten.controller.qpcc.pieces import reduce_piece
from tauten.controller.qpcc.problem import Qpcc
from tauten.controller.qpcc.qp import Qp, qp_backend
from tauten.controller.qpcc.qp_polish import polished
from tauten.controller.qpcc.scaling import in_rows
from tauten.controller.qpcc.search import Budget, branch_and_bound
from tauten.controller.qpcc.solve import approach

_FEW = 8  # pieces, and nodes of the search


def warm_solver(solver: str) -> None:
    """Compile or load all kernels of `solve_qpcc`, those of its rare ways too.

    Rare are pieces that a QP library must solve, answers that need polishing, degenerate points, limits in
    conflict and the search for any feasible point.

    Args:
        solver: QP back end, one of `qp.available_backends()`.

    Raises:
        ValueError: the back end is not installed.
    """
    backend = qp_backend(solver)
    for n_a in (1, 2):  # one tension has kernels of its own
        rows = in_rows(_small(n_a))
        _, scaled, _, _, _, piece, z = scaled_start(
            np.zeros(n_a), np.zeros(2, dtype=np.bool_), *rows
        )
        descent = Descent(scaled, backend, _FEW)
        point = descent.run(piece)
        descent.stay(z, piece)
        approach(descent, z, piece)
        if point is not None:
            descent.settle(point)
            list(descent.pieces_around(point))
        _, H, f, A, lower, upper, _ = reduce_piece(scaled, piece)
        qp = Qp(H, f, A, lower, upper)
        polished(qp, backend(qp))
        least_violation(scaled, backend, _FEW, piece)
        branch_and_bound(Descent(scaled, backend, _FEW), 0.0, Budget(nodes=_FEW, gap=0.0))


def _small(n_a: int) -> Qpcc:
    """Cables n_a and two contacts that push each other, both shut at the start without pushing."""
    n = n_a + 2
    M = np.hstack([-np.ones((2, n_a)), np.array([[1.0, 0.5], [0.5, 1.0]])])
    return Qpcc(
        Q=np.eye(n), c=-np.ones(n), lb=np.zeros(n_a), ub=np.ones(n_a),
        G=np.ones((1, n)), g_lo=np.array([-1.0]), g_hi=np.array([2.0]),
        M=M, m=np.zeros(2),
    )  # fmt: skip
