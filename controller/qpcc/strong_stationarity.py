"""Multipliers found from the point alone: is it strongly stationary, whatever the solver says?

A point is strongly stationary when multipliers with the right signs cancel the gradient (Scheel and
Scholtes 2000). Where active constraints depend on each other those of a piece's QP are only one choice,
so that their signs prove nothing; a nonnegative least squares problem looks at all choices at once.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import nnls

from tauten.controller.qpcc.residuals import ACTIVE, pair_values, row_values
from tauten.controller.qpcc.scaling import Scaled
from tauten.model.numerics import Array, Bools


def strong_multipliers(problem: Scaled, z: Array) -> tuple[Array, Array]:
    """The multipliers of right signs that come closest to cancelling the gradient at z.

    Returns:
        Those of the bounds (n_a,) and of the rows (2k + p,), with the signs of `pieces.recover`.
    """
    n, n_a, rows = len(z), len(problem.lb), len(problem.r)
    allowed = signs_allowed(problem, z)  # (n_a + rows, 2)
    constraints = np.vstack([np.eye(n_a, n), problem.R])  # (n_a + rows, n)
    up, down = np.flatnonzero(allowed[:, 0]), np.flatnonzero(allowed[:, 1])
    columns = np.vstack([constraints[up], -constraints[down]]).T  # (n, multipliers)
    norms = np.linalg.norm(columns, axis=0)
    norms[norms == 0.0] = 1.0
    multipliers = np.zeros(n_a + rows)
    if columns.shape[1] > 0:
        try:
            found = nnls(columns / norms, -(problem.Q @ z + problem.c))[0] / norms
        except RuntimeError:  # iteration limit: no multipliers, so nothing is claimed
            found = np.zeros(columns.shape[1])
        np.add.at(multipliers, up, found[: len(up)])
        np.subtract.at(multipliers, down, found[len(up) :])
    return multipliers[:n_a], multipliers[n_a:]


def signs_allowed(problem: Scaled, z: Array) -> Bools:
    """Whether a constraint may have a positive, a negative multiplier: (n_a + rows, 2) bool."""
    n_a = len(problem.lb)
    k = len(z) - n_a
    values, sizes = row_values(problem, z)
    allowed = np.zeros((n_a + len(values), 2), dtype=np.bool_)
    allowed[:n_a, 0], allowed[:n_a, 1] = z[:n_a] >= problem.ub, z[:n_a] <= problem.lb
    limits = slice(2 * k, None)
    lo, hi = problem.lo[limits], problem.hi[limits]
    allowed[n_a + 2 * k :, 0] = values[limits] >= hi - ACTIVE * (sizes[limits] + np.abs(hi))
    allowed[n_a + 2 * k :, 1] = values[limits] <= lo + ACTIVE * (sizes[limits] + np.abs(lo))
    beta, w = pair_values(problem, z, values, sizes)
    pushes, is_open = beta > ACTIVE, (beta <= ACTIVE) & (w > ACTIVE)
    allowed[n_a : n_a + k, 0] = is_open
    allowed[n_a : n_a + k, 1] = ~pushes
    allowed[n_a + k : n_a + 2 * k, 0] = pushes
    allowed[n_a + k : n_a + 2 * k, 1] = ~is_open
    return allowed
