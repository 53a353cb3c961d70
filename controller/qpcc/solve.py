"""Solve quadratic programs with complementarity constraints: an active set over pieces.

    from tauten.controller.qpcc.solve import Qpcc, solve_qpcc

Which modes push and which are open is a piece; on a piece the problem is a convex QP. Start from the
contact forces at the previous tensions, solve the piece, look at the multipliers of the pairs of which
both sides are zero, flip those that say the objective falls beyond, repeat until none does. docs/qpcc.md
explains it with a picture.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tauten.controller.qpcc.descent import Descent, Point
from tauten.controller.qpcc.elastic import least_violation
from tauten.controller.qpcc.lcp_start import scaled_start
from tauten.controller.qpcc.one_cable import within_limit
from tauten.controller.qpcc.problem import Qpcc, Start, Warm, start_of
from tauten.controller.qpcc.qp import qp_backend
from tauten.controller.qpcc.scaling import CROSSED_LIMITS, NOT_FINITE, Units, in_rows
from tauten.controller.qpcc.search import Budget, branch_and_bound
from tauten.controller.qpcc.solution import Certificate, Solution, Status
from tauten.model.numerics import Array, Bools

__all__ = ["Qpcc", "QpccSettings", "Start", "solve_qpcc"]


@dataclass(frozen=True, slots=True)
class QpccSettings:
    """How to solve.

    Attributes:
        solver: QP back end, one of `qp.available_backends()`.
        max_pivots: pieces solved at most before MAX_PIVOTS.
        search_time: wall time of the second phase [s], which looks for better local minima and bounds
            the objective; 0: none. Its results depend on the machine's speed.
        rescue_nodes: where the first phase finds no feasible point, nodes in which a search for one may
            go on before the status is INFEASIBLE.
    """

    solver: str = "daqp"
    max_pivots: int = 100
    search_time: float = 0.0
    rescue_nodes: int = 64


DEFAULT = QpccSettings()
UNLIMITED = 1_000_000
NO_PIECE = ("complementarity",)  # what is in conflict where no limit can be blamed


def solve_qpcc(problem: Qpcc, warm: Warm = None, settings: QpccSettings = DEFAULT) -> Solution:
    """Solve (1)-(3) to a stationary point, and with a search time towards the global optimum.

    Never raises on numbers: what is wrong with them is in the status. On anything but OK the best
    feasible point found comes back, or the one that violates the limits least.

    Args:
        problem: what to solve.
        warm: the last solution, or a `Start`, or a piece (k,) alone; None: start without tension. What
            does not fit the problem is ignored.
        settings: back end and limits.

    Raises:
        ValueError: the settings name a back end that is not installed.
    """
    backend = qp_backend(settings.solver)
    n_a, k = len(problem.lb), len(problem.m)
    given, guess = start_of(warm, n_a, k)
    numbers, scaled, units, lam_a, found, piece, z = scaled_start(given, guess, *in_rows(problem))
    if numbers == NOT_FINITE:
        return nothing(problem, Status.NOT_FINITE, given)
    if numbers == CROSSED_LIMITS:
        return nothing(problem, Status.INFEASIBLE, lam_a, crossed_limits(problem))
    descent = Descent(scaled, backend, settings.max_pivots)
    piece = piece if found else guess
    descent.run(piece)
    if found and (descent.best is None or not descent.best.stationary):
        descent.stay(z, piece)
    if found and descent.best is None:
        approach(descent, z, piece)
    violating = rescue(descent, piece, settings)
    bound = search(problem, descent, units, settings) if settings.search_time > 0.0 else -np.inf
    if descent.best is not None:
        return finish(problem, descent.best, units, descent, bound)
    if violating is not None:
        return infeasible(problem, units, violating, descent.pivots)
    return nothing(problem, Status.INFEASIBLE, lam_a, NO_PIECE)


def approach(descent: Descent, z: Array, piece: Bools) -> None:
    """Descend from a point within the limits near one that is not, where that is cheap to find."""
    problem = descent.problem
    if len(problem.lb) != 1 or len(problem.r) != 2 * len(piece) + 1:
        return
    found, piece, z = within_limit(problem, z, piece)
    if found:
        descent.run_or_stay(z, piece)


def rescue(descent: Descent, piece: Bools, settings: QpccSettings) -> Point | None:
    """Find a feasible point for a descent that has none, decide one that got stuck.

    Returns:
        Where there is no feasible point, the least violating one.
    """
    best = descent.best
    if best is not None and (best.stationary or descent.exhausted):
        return None
    violating = None
    if best is None:
        violating = least_violation(descent.problem, descent.backend, descent.max_pivots, piece)
    if violating is not None:
        descent.run_or_stay(violating.z, violating.piece)
    best = descent.best
    if best is None or not best.stationary:
        budget = Budget(nodes=settings.rescue_nodes, gap=0.0, any_point=best is None)
        branch_and_bound(descent, 0.0, budget)
    return violating


def search(problem: Qpcc, descent: Descent, units: Units, settings: QpccSettings) -> float:
    """The second phase; the bound it gives on the objective."""
    wide = replace(descent, max_pivots=UNLIMITED)
    budget = Budget(seconds=settings.search_time)
    proof = branch_and_bound(wide, problem.constant / units.cost, budget)
    descent.best = wide.best
    return proof.bound * units.cost + problem.constant


def finish(problem: Qpcc, best: Point, units: Units, descent: Descent, bound: float) -> Solution:
    """The best point of a descent, in the problem's units."""
    if best.stationary:
        status = Status.OK
    else:
        status = Status.MAX_PIVOTS if descent.exhausted else Status.FEASIBLE_ONLY
    best_value = best.worth.objective * units.cost + problem.constant
    return solution_at(problem, units, best, status, descent.pivots, bound=min(bound, best_value))


def infeasible(problem: Qpcc, units: Units, violating: Point, pivots: int) -> Solution:
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
    return solution_at(problem, units, violating, Status.INFEASIBLE, pivots, conflict)


def solution_at(
    problem: Qpcc,
    units: Units,
    point: Point,
    status: Status,
    pivots: int,
    conflict: tuple[str, ...] = (),
    bound: float = -np.inf,
) -> Solution:
    """A point in the problem's units."""
    n_a, z, worth = len(problem.lb), point.z * units.column, point.worth
    lam_a = np.minimum(np.maximum(z[:n_a], problem.lb), problem.ub)  # exact beyond UNBOUNDED too
    return Solution(
        lam_a=lam_a,
        beta=z[n_a:],
        status=status,
        certificate=Certificate(worth.primal, worth.complementarity, worth.stationarity, np.inf),
        objective=worth.objective * units.cost + problem.constant,
        pivots=pivots,
        piece=point.piece,
        conflict=conflict,
        bound=bound,
    )


def nothing(
    problem: Qpcc, status: Status, lam_a: Array, conflict: tuple[str, ...] = ()
) -> Solution:
    """Nothing to offer but the tensions to stay at."""
    k = len(problem.m)
    unknown = Certificate(np.inf, np.inf, np.inf, np.inf)
    piece = np.zeros(k, dtype=np.bool_)
    return Solution(lam_a, np.zeros(k), status, unknown, np.inf, 0, piece, conflict)


def crossed_limits(problem: Qpcc) -> tuple[str, ...]:
    """Names of limits whose lower end lies above the upper."""
    p = problem
    bounds = np.flatnonzero((p.lb > p.ub) | (p.lb == np.inf) | (p.ub == -np.inf))
    rows = np.flatnonzero((p.g_lo > p.g_hi) | (p.g_lo == np.inf) | (p.g_hi == -np.inf))
    names = [p.name_of_bound(j) for j in bounds.tolist()]
    names += [p.name_of_row(i, upper) for i in rows.tolist() for upper in (False, True)]
    return tuple(dict.fromkeys(names))
