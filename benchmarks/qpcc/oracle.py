"""Exact answers to QPCCs, slowly: what the solver is measured against.

`enumerate_pieces` solves all 2ᵏ pieces, `scip_optimum` calls a mixed-integer solver that shares no code
with ours (Bolusani et al., The SCIP Optimization Suite 9.0, 2024; package pyscipopt).
"""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np

from tauten.controller.qpcc import UNBOUNDED, USABLE, Qpcc, Scaled, qp_backend, scale, solve_piece
from tauten.model.numerics import Bools

FEASIBLE = 1e-7  # with 1e-8 its LP solver runs into numerical trouble


def enumerate_pieces(problem: Qpcc, solver: str = "daqp") -> tuple[float, Bools]:
    """The lowest objective over all pieces, +inf without a feasible one, and its piece (k,)."""
    numbers, scaled, units = scale(problem)
    best, best_piece = np.inf, np.zeros(len(problem.m), dtype=np.bool_)
    if numbers != USABLE:
        return best, best_piece
    for choice in product((False, True), repeat=len(problem.m)):
        piece = np.array(choice, dtype=np.bool_)
        point = solve_piece(scaled, piece, qp_backend(solver))
        if point is not None and point.residuals.objective < best:
            best, best_piece = point.residuals.objective, piece
    return best * units.cost + problem.constant, best_piece


def scip_optimum(problem: Qpcc, seconds: float = 60.0) -> tuple[float, float]:
    """The objective that SCIP finds and the bound it proves; both +inf when it reports infeasibility.

    +inf and -inf when it fails, as its LP solver does on some degenerate problems.

    Its tolerances are absolute, 1e-7 on a problem whose objective is of order one before the constant is
    added, so expect six digits of what the objective is summed from to agree.

    Raises:
        ValueError: the numbers of the problem are not usable.
    """
    numbers, scaled, units = scale(problem)
    if numbers != USABLE:
        raise ValueError("the problem has numbers that are not finite or limits that cross")
    tau = max(float(np.abs(scaled.c).max(initial=0.0)), 1e-12)
    model = scip_model(shrunk(scaled, tau))
    model.setParam("limits/time", seconds)
    try:
        model.optimize()
    except Exception:  # all that pyscipopt raises when an LP fails
        return np.inf, -np.inf
    if model.getStatus() == "infeasible":
        return np.inf, np.inf
    objective = model.getObjVal() if model.getNSols() > 0 else np.inf
    offset, cost, bound = problem.constant, units.cost * tau**2, model.getDualbound()
    return objective * cost + offset, bound * cost + offset


def shrunk(problem: Scaled, tau: float) -> Scaled:
    """The problem in z / τ, with its objective divided by τ²."""
    r, limits = problem.r / tau, []
    for side in (problem.lb, problem.ub, problem.lo, problem.hi):
        limits.append(np.where(np.abs(side) >= UNBOUNDED, side, side / tau))
    lb, ub, lo, hi = limits
    return Scaled(problem.Q, problem.c / tau, lb, ub, problem.R, r, lo, hi)


def scip_model(problem: Scaled) -> Any:
    """The QPCC with w as variables, SOS1 pairs and the objective as a sum of squares."""
    from pyscipopt import Model, quicksum

    n_a, n = len(problem.lb), len(problem.c)
    k = n - n_a
    model = Model()
    model.hideOutput()
    model.setParam("numerics/feastol", FEASIBLE)
    model.setParam("limits/gap", 1e-8)
    lower = [*map(limit, problem.lb), *[0.0] * k]
    upper = [*map(limit, problem.ub), *[None] * k]
    z = [model.addVar(lb=low, ub=high) for low, high in zip(lower, upper, strict=True)]
    w = [model.addVar(lb=0.0) for _ in range(k)]
    R, r = problem.R, problem.r
    rows = [quicksum(R[i, j] * z[j] for j in np.flatnonzero(R[i])) + r[i] for i in range(len(r))]
    for i in range(k):
        model.addCons(w[i] == rows[k + i])
        model.addConsSOS1([z[n_a + i], w[i]])
    for i in range(2 * k, len(r)):
        if limit(problem.hi[i]) is not None:
            model.addCons(rows[i] <= problem.hi[i])
        if limit(problem.lo[i]) is not None:
            model.addCons(rows[i] >= problem.lo[i])
    values, vectors = np.linalg.eigh(problem.Q)
    kept = values > 1e-14 * values.max(initial=0.0)
    factor = vectors[:, kept] * np.sqrt(values[kept])  # (n, rank)
    squares = [model.addVar(lb=None) for _ in range(factor.shape[1])]
    for column, square in zip(factor.T, squares, strict=True):
        model.addCons(square == quicksum(column[j] * z[j] for j in range(n)))
    value = model.addVar(lb=None)
    linear = quicksum(problem.c[j] * z[j] for j in range(n))
    model.addCons(value >= 0.5 * quicksum(square * square for square in squares) + linear)
    model.setObjective(value)
    return model


def limit(value: float) -> float | None:
    """None for a limit that is none."""
    return None if abs(value) >= UNBOUNDED else float(value)
