"""Solve quadratic programs with complementarity constraints: an active set over pieces.

Which modes push and which are open is a piece; on a piece the problem is a convex QP. Start from the
contact forces at the previous tensions, solve the piece, check the multipliers of the pairs of which
both sides are zero, flip those whose multipliers show that the objective decreases in the adjacent
piece, repeat until there are none. docs/qpcc.md explains it with a picture.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from tauten.controller.qpcc.descent import Budget, Descent, DescentPoint
from tauten.controller.qpcc.feasible import all_empty, least_violation
from tauten.controller.qpcc.homotopy import penalty_homotopy
from tauten.controller.qpcc.piece import settle_one_cable
from tauten.controller.qpcc.problem import Qpcc, QpccArrays, Warm, start_of
from tauten.controller.qpcc.qp import Backend, qp_backend, solve_daqp
from tauten.controller.qpcc.residuals import EXACT, FLOOR, RIDGE, Residuals
from tauten.controller.qpcc.scaling import (
    NOT_FINITE,
    USABLE,
    Scaled,
    Units,
    largest_magnitude,
    scale_into,
    space_for,
)
from tauten.controller.qpcc.solution import Certificate, Solution, Status
from tauten.controller.qpcc.time_limit import TimeLimit
from tauten.model.numerics import Array, Bools, active_set_forces, kernel


@dataclass(frozen=True, slots=True)
class QpccSettings:
    """How to solve.

    Attributes:
        solver: QP library, one of `qp.available_backends()`, or a function; see `qp.qp_backend`.
        max_pivots: QPs solved at most, in all phases together.
        time_limit: wall time [s], in all phases together; it may be exceeded by one QP.
        second_start: when a penalty homotopy looks for a lower optimum from a second start: "cold", without
            a warm start; "always", which takes milliseconds; "never". It also runs where no feasible point
            is found otherwise.
    """

    solver: str | Backend = "daqp"
    max_pivots: int = 300
    time_limit: float = math.inf
    second_start: Literal["cold", "always", "never"] = "cold"


DEFAULT = QpccSettings()
NO_PIECE = ("complementarity",)  # what is in conflict where no limit is the cause


def solve_qpcc(problem: Qpcc, warm: Warm = None, settings: QpccSettings = DEFAULT) -> Solution:
    """Solve (1)-(3) to a stationary point.

    Never raises on numbers: what is wrong with them is in the status. On anything but OK the best
    feasible point found comes back, or the one that violates the limits least.

    Args:
        problem: the QPCC.
        warm: the last solution, or a `Start`, or a piece (k,) alone; None: start without tension. What
            does not fit the problem is ignored.
        settings: library and limits.

    Raises:
        ValueError: the settings name a library that is not installed.
    """
    backend = qp_backend(settings.solver)
    arrays, z = problem.arrays, np.zeros(len(problem.c))
    lam_a, piece = start_of(warm, len(problem.lb), len(problem.m))
    scaled, column = space_for(arrays)
    numbers, cost, found = start(arrays, scaled, column, lam_a, piece, z)
    units = Units(column, cost)
    if numbers != USABLE:
        return unusable(problem, numbers, lam_a)
    twice = settings.second_start == "always" or (warm is None and settings.second_start == "cold")
    if not twice and len(lam_a) == 1 and backend is solve_daqp and settings.max_pivots > 0:
        settled, residuals = settle_one_cable(scaled, piece, z)
        if settled:
            return solution_at(problem, units, z, piece, residuals, Status.OK, 1)
    budget = Budget(settings.max_pivots, TimeLimit(settings.time_limit))
    descent = Descent(scaled, backend, budget)
    descent.run(piece)
    if found and (descent.best is None or not descent.best.stationary):
        descent.keep_point(z, piece)
    if twice:
        penalty_homotopy(descent)
    if not descent.has_point():
        violating = least_violation(descent, piece)
        if not descent.has_point() and not twice:
            penalty_homotopy(descent)
        empty = not descent.has_point() and all_empty(descent)
    if descent.best is not None:
        return finish(problem, descent.best, units, budget)
    status = Status.INFEASIBLE if empty else Status.NOT_FOUND
    if violating is not None:
        return infeasible(problem, units, violating, status, budget.spent)
    return nothing(problem, status, lam_a, NO_PIECE, budget.spent)


@kernel
def start(
    problem: QpccArrays, scaled: Scaled, column: Array, lam_a: Array, piece: Bools, z: Array
) -> tuple[int, float, bool]:
    """Write the scaled problem, and the contact forces at given tensions.

    Args:
        problem: contiguous arrays of the QPCC.
        scaled: output, and
        column: output, the units of z, see `scaling.space_for`.
        lam_a: (n_a,) tensions to start from [N], brought within their bounds.
        piece: (k,) modes that are expected to push, overwritten by those that do.
        z: (n,) output, (a, β) scaled.

    Returns:
        Whether the numbers are USABLE, the unit of the objective, whether contact forces were found.
    """
    numbers, cost = scale_into(problem, scaled, column)
    lb, ub = problem.lb, problem.ub
    for j in range(len(lb)):
        within = min(max(lam_a[j], lb[j]), ub[j])
        lam_a[j] = within if abs(within) < np.inf else 0.0
    if numbers != USABLE:
        return numbers, cost, False
    found, pushes, z[:] = contact_forces(scaled, lam_a / column[: len(lam_a)], piece)
    if found:
        piece[:] = pushes
    return numbers, cost, found


@kernel
def contact_forces(problem: Scaled, a: Array, guess: Bools) -> tuple[bool, Bools, Array]:
    """The contact forces at tensions a: found, which modes push (k,), z = (a, β).

    0 <= w = N β + q ⟂ β >= 0 by the active set of `model.lcp`, for which N must be symmetric and positive
    semidefinite, as compliances are; elsewhere the answer may fail the test.

    Args:
        problem: scaled.
        a: (n_a,) tensions, scaled.
        guess: (k,) modes that are expected to push.
    """
    n_a, k = len(a), len(guess)
    N = problem.R[k : 2 * k, n_a:].copy()
    q = problem.r[k : 2 * k] + problem.R[k : 2 * k, :n_a].copy() @ a
    beta, _ = active_set_forces(N, q, guess.astype(np.float64), RIDGE, 100 + 10 * k)
    found, pushes = True, beta > 0.0
    floor = FLOOR * largest_magnitude(beta)
    for i in range(k):
        w, size = q[i], max(abs(q[i]), floor)
        for j in range(k):
            if pushes[j]:
                w += N[i, j] * beta[j]
                size += abs(N[i, j] * beta[j])
        side = min(beta[i] * N[i, i], w)
        found = found and abs(side) <= EXACT * size
    return found, pushes, np.concatenate((a, beta))


def finish(problem: Qpcc, best: DescentPoint, units: Units, budget: Budget) -> Solution:
    """The best point of a descent, in the problem's units."""
    status = Status.OK
    if not best.stationary:
        status = Status.MAX_PIVOTS if budget.exhausted else Status.FEASIBLE_ONLY
    return solution_at(problem, units, best.z, best.piece, best.residuals, status, budget.spent)


def infeasible(
    problem: Qpcc, units: Units, violating: DescentPoint, status: Status, pivots: int
) -> Solution:
    """The least violating point, with the names of the limits in conflict.

    Those are the limits it violates, and the bounds that keep it from violating them less.
    """
    limits = violating.dual[2 * len(problem.m) :]  # (p,) minus the violations
    pressing = 1e-6 * np.abs(limits).max(initial=0.0)
    names = [
        problem.name_of_row(i, upper=limits[i] > 0.0)
        for i in np.flatnonzero(np.abs(limits) > pressing).tolist()
    ]
    names += [
        problem.name_of_bound(j)
        for j in np.flatnonzero(np.abs(violating.alpha) > pressing).tolist()
    ]
    conflict = tuple(names) or NO_PIECE
    z, piece = violating.z, violating.piece
    return solution_at(problem, units, z, piece, violating.residuals, status, pivots, conflict)


def solution_at(
    problem: Qpcc,
    units: Units,
    z: Array,
    piece: Bools,
    found: Residuals,
    status: Status,
    pivots: int,
    conflict: tuple[str, ...] = (),
) -> Solution:
    """A point in the problem's units.

    Args:
        problem: the QPCC.
        units: of the scaled problem.
        z: (n,) scaled.
        piece: (k,) which modes push.
        found: residuals of the point.
        status: how the solve ended.
        pivots: number of QPs solved.
        conflict: names of the limits in conflict.
    """
    n_a, z = len(problem.lb), z * units.column
    lam_a = np.minimum(np.maximum(z[:n_a], problem.lb), problem.ub)  # exact beyond UNBOUNDED too
    return Solution(
        lam_a=lam_a,
        beta=z[n_a:],
        status=status,
        certificate=Certificate(found.primal, found.complementarity, found.stationarity, np.inf),
        objective=found.objective * units.cost + problem.constant,
        pivots=pivots,
        piece=piece,
        conflict=conflict,
    )


def unusable(problem: Qpcc, numbers: int, lam_a: Array) -> Solution:
    """The answer to a problem that is not finite, or whose limits are crossed.

    Args:
        problem: the QPCC.
        numbers: NOT_FINITE or CROSSED_LIMITS.
        lam_a: (n_a,) tensions of the start [N].
    """
    if numbers == NOT_FINITE:
        return nothing(problem, Status.NOT_FINITE, lam_a)
    return nothing(problem, Status.INFEASIBLE, lam_a, crossed_limits(problem))


def nothing(
    problem: Qpcc, status: Status, lam_a: Array, conflict: tuple[str, ...] = (), pivots: int = 0
) -> Solution:
    """The tensions of the start, where there is no point to return.

    Args:
        problem: the QPCC.
        status: how the solve ended.
        lam_a: (n_a,) tensions of the start [N].
        conflict: names of the limits in conflict.
        pivots: number of QPs solved.
    """
    k = len(problem.m)
    unknown = Certificate(np.inf, np.inf, np.inf, np.inf)
    piece = np.zeros(k, dtype=np.bool_)
    return Solution(lam_a, np.zeros(k), status, unknown, np.inf, pivots, piece, conflict)


def crossed_limits(problem: Qpcc) -> tuple[str, ...]:
    """Names of limits whose lower end lies above the upper."""
    p = problem
    bounds = np.flatnonzero((p.lb > p.ub) | (p.lb == np.inf) | (p.ub == -np.inf))
    rows = np.flatnonzero((p.g_lo > p.g_hi) | (p.g_lo == np.inf) | (p.g_hi == -np.inf))
    names = [p.name_of_bound(j) for j in bounds.tolist()]
    names += [p.name_of_row(i, upper) for i in rows.tolist() for upper in (False, True)]
    return tuple(dict.fromkeys(names))
