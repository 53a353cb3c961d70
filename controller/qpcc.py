"""Quadratic programs with complementarity constraints, solved by an active set over pieces.

    min  1/2 z'Qz + c'z,   z = (a, β)                                                          (1)
    s.t. lb <= a <= ub,   g_lo <= G z <= g_hi                                                  (2)
         0 <= w = M z + m   ⟂   β >= 0                                                         (3)

a (n_a,) are tensions [N], β (k,) reduced contact forces [N], w (k,) reduced gaps [m]. (T1) of Goury, Carrez,
Duriez has this form (`inverse.inverse_problem`), but nothing here knows of robots.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from tauten.controller.lcp_start import solve_lcp
from tauten.controller.qp import qp_backend
from tauten.controller.qpcc_descent import Descent, Point
from tauten.controller.qpcc_elastic import least_violation
from tauten.controller.qpcc_scaling import Scaled, equilibrate
from tauten.controller.solution import Certificate, Solution, Status
from tauten.model.arrays import Array, Bools


@dataclass(frozen=True, slots=True)
class Qpcc:
    """Problem (1)-(3), n = n_a + k.

    Attributes:
        Q: (n, n) symmetric positive semidefinite.
        c: (n,).
        lb: (n_a,) -inf for none.
        ub: (n_a,) +inf for none.
        G: (p, n).
        g_lo: (p,).
        g_hi: (p,).
        M: (k, n).
        m: (k,).
        constant: added to the objective.
        bound_names: (n_a,) what a bound is called when it is in conflict.
        row_names: (p,) what the lower and the upper limit of a row are called.
    """

    Q: Array
    c: Array
    lb: Array
    ub: Array
    G: Array
    g_lo: Array
    g_hi: Array
    M: Array
    m: Array
    constant: float = 0.0
    bound_names: tuple[str, ...] = ()
    row_names: tuple[tuple[str, str], ...] = ()

    def __post_init__(self) -> None:
        n, n_a, k, p = len(self.c), len(self.lb), len(self.m), len(self.g_lo)
        shapes = {
            "Q": (self.Q, (n, n)), "c": (self.c, (n_a + k,)), "ub": (self.ub, (n_a,)),
            "G": (self.G, (p, n)), "g_hi": (self.g_hi, (p,)), "M": (self.M, (k, n)),
        }  # fmt: skip
        for name, (array, shape) in shapes.items():
            if array.shape != shape:
                raise ValueError(
                    f"Qpcc: {name} has shape {array.shape}, {shape} is needed for "
                    f"{n_a} bounds, {k} complementarity rows and {p} limits"
                )

    def objective(self, lam_a: Array, beta: Array) -> float:
        """(1) with its constant."""
        z = np.concatenate([lam_a, beta])
        return float(z @ (0.5 * (self.Q @ z) + self.c)) + self.constant


@dataclass(frozen=True, slots=True)
class Start:
    """Where to start: what is known of the step before.

    Attributes:
        lam_a: (n_a,) tensions; the solution is never worse than these with the contact forces they
            cause, as long as they satisfy the limits.
        piece: (k,) modes that pushed.
    """

    lam_a: Array
    piece: Bools


@dataclass(frozen=True, slots=True)
class QpccSettings:
    """How to solve.

    Attributes:
        solver: QP back end, one of `qp.available_backends()`.
        max_pivots: pieces solved at most before MAX_PIVOTS.
    """

    solver: str = "daqp"
    max_pivots: int = 100


DEFAULT = QpccSettings()


def solve_qpcc(
    problem: Qpcc, warm: Start | Solution | Bools | None = None, settings: QpccSettings = DEFAULT
) -> Solution:
    """Solve (1)-(3) to a stationary point.

    Never raises on numbers: what is wrong with them is in the status, and the best point found comes back.

    Args:
        problem: what to solve.
        warm: the last solution, or its tensions and piece, or its piece alone; None: start at no tension.
        settings: back end and limits.

    Raises:
        ValueError: the settings name a back end that is not installed.
    """
    backend = qp_backend(settings.solver)
    n_a, k = len(problem.lb), len(problem.m)
    lam_a, piece = start_of(warm, n_a, k)
    if not finite(problem):
        return no_solution(problem, Status.NOT_FINITE, lam_a)
    lam_a = np.minimum(np.maximum(lam_a, problem.lb), problem.ub)
    conflict = empty_limits(problem)
    if conflict:
        return no_solution(problem, Status.INFEASIBLE, lam_a, conflict)
    scaled = scale(problem)
    descent = Descent(scaled, backend, settings.max_pivots)
    q = scaled.r[k : 2 * k] + scaled.R[k : 2 * k, :n_a] @ (lam_a / scaled.column[:n_a])
    found, feasible_piece = solve_lcp(np.ascontiguousarray(scaled.R[k : 2 * k, n_a:]), q, piece)
    point = descent.run(feasible_piece) if found else None
    if point is None:
        point = descent.run(piece)
    conflict = ()
    if point is None and found:
        elastic = least_violation(scaled, backend, settings.max_pivots, feasible_piece)
        if elastic is not None:
            point = descent.run(elastic.piece)
            if point is None:
                return infeasible(problem, scaled, elastic, descent.pivots)
    if descent.best is None:
        return no_solution(problem, Status.INFEASIBLE, lam_a, ("complementarity",))
    return finish(problem, scaled, descent)


def scale(problem: Qpcc) -> Scaled:
    """The problem without units."""
    p = problem
    arrays = (p.Q, p.c, p.lb, p.ub, p.G, p.g_lo, p.g_hi, p.M, p.m)
    # copies: a kernel is compiled anew for every memory layout, and that must not happen in a loop
    return Scaled(*equilibrate(*(np.array(array, dtype=float, order="C") for array in arrays)))


def finish(problem: Qpcc, scaled: Scaled, descent: Descent) -> Solution:
    """The best point of a descent, in the problem's units."""
    best = descent.best
    assert best is not None
    if best.stationary:
        status = Status.OK
    elif descent.pivots >= descent.max_pivots:
        status = Status.MAX_PIVOTS
    else:
        status = Status.FEASIBLE_ONLY
    return solution_at(problem, scaled, best, status, descent.pivots)


def solution_at(
    problem: Qpcc, scaled: Scaled, point: Point, status: Status, pivots: int,
    conflict: tuple[str, ...] = (),
) -> Solution:  # fmt: skip
    """A point in the problem's units."""
    z = point.z * scaled.column
    n_a = len(problem.lb)
    # the units of the scaling may round a bound; the limits of a cable are not to be passed by even that
    lam_a = np.minimum(np.maximum(z[:n_a], problem.lb), problem.ub)
    return Solution(
        lam_a=lam_a,
        beta=z[n_a:],
        status=status,
        certificate=Certificate(point.primal, point.complementarity, point.stationarity, np.inf),
        objective=problem.objective(lam_a, z[n_a:]),
        pivots=pivots,
        piece=point.piece,
        conflict=conflict,
    )


def infeasible(problem: Qpcc, scaled: Scaled, elastic: Point, pivots: int) -> Solution:
    """The least violating point, and the limits that its multipliers say are in conflict."""
    n_a, p = len(problem.lb), len(problem.g_lo)
    names = []
    multipliers = elastic.dual[-p:] if p else np.zeros(0)
    for i in np.flatnonzero(np.abs(multipliers) > 1e-6 * np.abs(multipliers).max(initial=0.0)):
        lower, upper = problem.row_names[i] if problem.row_names else (f"row {i}", f"row {i}")
        names.append(upper if multipliers[i] > 0.0 else lower)
    held = elastic.alpha[:n_a]
    for j in np.flatnonzero(np.abs(held) > 1e-6 * np.abs(multipliers).max(initial=0.0)):
        names.append(problem.bound_names[j] if problem.bound_names else f"bound {j}")
    return solution_at(problem, scaled, elastic, Status.INFEASIBLE, pivots, tuple(names))


def no_solution(
    problem: Qpcc, status: Status, lam_a: Array, conflict: tuple[str, ...] = ()
) -> Solution:
    """Nothing to offer but the tensions to stay at."""
    k = len(problem.m)
    nothing = Certificate(np.inf, np.inf, np.inf, np.inf)
    return Solution(lam_a, np.zeros(k), status, nothing, np.inf, 0, np.zeros(k, bool), conflict)


def start_of(warm: Start | Solution | Bools | None, n_a: int, k: int) -> tuple[Array, Bools]:
    """Tensions and piece to start from; what does not fit is ignored."""
    lam_a, piece = np.zeros(n_a), np.zeros(k, dtype=bool)
    if isinstance(warm, np.ndarray):
        given, pieces = lam_a, warm
    elif warm is not None:
        given, pieces = warm.lam_a, warm.piece
    else:
        return lam_a, piece
    if given.shape == (n_a,) and np.isfinite(given).all():
        lam_a = given
    if pieces.shape == (k,):
        piece = pieces.astype(bool)
    return lam_a, piece


def finite(problem: Qpcc) -> bool:
    """No NaN anywhere, infinity only in limits."""
    p = problem
    numbers = all(np.isfinite(array).all() for array in (p.Q, p.c, p.G, p.M, p.m))
    return bool(numbers and not any(np.isnan(a).any() for a in (p.lb, p.ub, p.g_lo, p.g_hi)))


def empty_limits(problem: Qpcc) -> tuple[str, ...]:
    """Names of limits whose lower end lies above the upper."""
    p = problem
    names = [
        p.bound_names[j] if p.bound_names else f"bound {j}"
        for j in np.flatnonzero((p.lb > p.ub) | (p.lb == np.inf) | (p.ub == -np.inf))
    ]
    for i in np.flatnonzero((p.g_lo > p.g_hi) | (p.g_lo == np.inf) | (p.g_hi == -np.inf)):
        names += sorted(set(p.row_names[i])) if p.row_names else [f"row {i}"]
    return tuple(names)
