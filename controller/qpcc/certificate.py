"""Judge an answer to a QPCC from the problem and the answer alone."""

from __future__ import annotations

import numpy as np

from tauten.controller.qpcc.problem import Qpcc
from tauten.controller.qpcc.residuals import judge
from tauten.controller.qpcc.scaling import USABLE, scale
from tauten.controller.qpcc.solution import Certificate
from tauten.controller.qpcc.strong_stationarity import strong_multipliers
from tauten.model.numerics import Array


def certify(problem: Qpcc, lam_a: Array, beta: Array) -> Certificate:
    """Residuals of a point, with the multipliers that speak for it best.

    The multipliers come from a nonnegative least squares problem, not from a solver's word, so that all three
    residuals of 1e-8 or less prove that the point is strongly stationary, whoever found it. Slower than the
    certificate that `solve_qpcc` returns, which uses the multipliers at hand.

    Args:
        problem: the QPCC.
        lam_a: (n_a,) tensions.
        beta: (k,) contact forces.
    """
    numbers, scaled, units = scale(problem)
    if numbers != USABLE:
        return Certificate(np.inf, np.inf, np.inf, np.inf)
    z = np.concatenate([lam_a, beta]) / units.column
    worth = judge(scaled, z, *strong_multipliers(scaled, z))
    return Certificate(worth.primal, worth.complementarity, worth.stationarity, np.inf)
