"""One convex QP, and the only module that names a QP library.

    min 1/2 y'Hy + f'y   subject to   lower <= (y, A y) <= upper                       (1)

The first n entries of `lower`, `upper` bound the variables, the others the rows of A. Entries beyond
±UNBOUNDED are no bounds. The QPs of a QPCC are tiny (n <= 10, m <= 60) and solved thousands of times a
second, so that setting up and wrapping cost more than the iterations: `daqp`, `proxqp`, `osqp` and
`quadprog` are called directly, any other solver that qpsolvers finds goes through its wrapper.
"""

from __future__ import annotations

import importlib.util
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.sparse import csc_matrix

from tauten.model.numerics import Array, Ints

UNBOUNDED = 1e30
ACCURACY = 1e-10  # primal and dual, on QPs whose variables and Hessian are of order one
ROUGH = 1e-6  # where only the active set matters, because the answer is polished anyway
DAQP_INFEASIBLE = -1  # exit flag


@dataclass(frozen=True, slots=True)
class Qp:
    """Problem (1).

    Attributes:
        H: (n, n) symmetric positive semidefinite.
        f: (n,).
        A: (m, n).
        lower: (n + m,).
        upper: (n + m,).
    """

    H: Array
    f: Array
    A: Array
    lower: Array
    upper: Array


@dataclass(frozen=True, slots=True)
class QpAnswer:
    """What a back end found. How good it is, its residuals say, not the back end.

    Attributes:
        infeasible: the back end says that there is no feasible point; y is then not to be used.
        y: (n,).
        multipliers: (n + m,) Hy + f + (I, A')·multipliers = 0; positive at upper, negative at lower.
    """

    infeasible: bool
    y: Array
    multipliers: Array


Backend = Callable[[Qp], QpAnswer]


def available_backends() -> tuple[str, ...]:
    """Names that `qp_backend` accepts on this machine, the default first."""
    import qpsolvers

    direct = [name for name in DIRECT if importlib.util.find_spec(LIBRARY[name]) is not None]
    return tuple(direct + [name for name in qpsolvers.available_solvers if name not in DIRECT])


@cache
def qp_backend(name: str) -> Backend:
    """The function that solves (1) with a named library.

    Raises:
        ValueError: the library is not installed or unknown.
    """
    known = available_backends()
    if name not in known:
        raise ValueError(f"QP solver {name!r} is not installed, found are {', '.join(known)}")
    return DIRECT[name] if name in DIRECT else wrapped(name)


def nothing(qp: Qp, infeasible: bool) -> QpAnswer:
    """The answer of a back end that has none."""
    return QpAnswer(infeasible, np.zeros(len(qp.f)), np.zeros(len(qp.lower)))


def solve_daqp(qp: Qp) -> QpAnswer:
    """Dual active set (Arnström, Bemporad, Axehill 2022): exact up to round-off."""
    import daqp

    y, _, flag, info = daqp.solve(qp.H, qp.f, qp.A, qp.upper, qp.lower, primal_tol=ACCURACY)
    return QpAnswer(flag == DAQP_INFEASIBLE, y, info["lam"])


def solve_proxqp(qp: Qp) -> QpAnswer:
    """Augmented Lagrangian with an active-set flavour (Bambade et al. 2022), dense."""
    from proxsuite import proxqp

    n, m = len(qp.f), len(qp.lower) - len(qp.f)
    solver = proxqp.dense.QP(n, 0, m, True)
    settings = solver.settings
    settings.eps_abs, settings.eps_rel = ACCURACY, 0.0
    # without the duality gap it accepts points whose multipliers press on inactive limits
    settings.check_duality_gap = True
    settings.eps_duality_gap_abs, settings.eps_duality_gap_rel = ACCURACY, 0.0
    # infeasible problems otherwise run for seconds
    settings.max_iter, settings.max_iter_in = 100, 100
    lower, upper = qp.lower, qp.upper
    solver.init(qp.H, qp.f, None, None, qp.A, lower[n:], upper[n:], lower[:n], upper[:n])
    solver.solve()
    z = solver.results.z
    infeasible = solver.results.info.status == proxqp.PROXQP_PRIMAL_INFEASIBLE
    return QpAnswer(infeasible, solver.results.x, np.concatenate([z[m:], z[:m]]))


def solve_osqp(qp: Qp) -> QpAnswer:
    """Operator splitting (Stellato et al. 2020)."""
    import osqp

    rows = csc_matrix(np.vstack([np.eye(len(qp.f)), qp.A]))
    solver = osqp.OSQP()
    try:
        solver.setup(
            csc_matrix(np.triu(qp.H)), qp.f, rows, qp.lower, qp.upper,
            eps_abs=ROUGH, eps_rel=ROUGH, max_iter=4000, polishing=False, verbose=False,
        )  # fmt: skip
    except osqp.OSQPException:  # it finds H, convex up to round-off, not convex
        return nothing(qp, infeasible=False)
    result = solver.solve(raise_error=False)
    infeasible = result.info.status_val == osqp.SolverStatus.OSQP_PRIMAL_INFEASIBLE
    return nothing(qp, infeasible) if result.x is None else QpAnswer(infeasible, result.x, result.y)


def solve_quadprog(qp: Qp) -> QpAnswer:
    """Goldfarb and Idnani (1983); H must be positive definite."""
    import quadprog

    rows = np.vstack([np.eye(len(qp.f)), qp.A])
    low, high = np.flatnonzero(qp.lower > -UNBOUNDED), np.flatnonzero(qp.upper < UNBOUNDED)
    C = np.vstack([rows[low], -rows[high]])
    b = np.concatenate([qp.lower[low], -qp.upper[high]])
    try:
        y, _, _, _, lagrangian, _ = quadprog.solve_qp(qp.H, -qp.f, np.ascontiguousarray(C.T), b)
    except ValueError as error:
        return nothing(qp, infeasible="inconsistent" in str(error))
    return QpAnswer(False, y, two_sided(qp, low, high, lagrangian))


def wrapped(name: str) -> Backend:
    """Any solver of qpsolvers, through its wrapper."""

    def solve(qp: Qp) -> QpAnswer:
        import qpsolvers

        n = len(qp.f)
        low = np.flatnonzero(qp.lower[n:] > -UNBOUNDED)
        high = np.flatnonzero(qp.upper[n:] < UNBOUNDED)
        G = np.vstack([-qp.A[low], qp.A[high]])
        h = np.concatenate([-qp.lower[n:][low], qp.upper[n:][high]])
        lb = np.where(qp.lower[:n] <= -UNBOUNDED, -np.inf, qp.lower[:n])
        ub = np.where(qp.upper[:n] >= UNBOUNDED, np.inf, qp.upper[:n])
        sparse = name in qpsolvers.sparse_solvers and name not in qpsolvers.dense_solvers
        matrix = csc_matrix if sparse else np.asarray
        problem = qpsolvers.Problem(matrix(qp.H), qp.f, matrix(G), h, lb=lb, ub=ub)
        try:
            with warnings.catch_warnings():  # an infeasible piece is no news
                warnings.simplefilter("ignore")
                found = qpsolvers.solve_problem(problem, solver=name)
        except (qpsolvers.exceptions.QPError, ValueError, ArithmeticError):
            return nothing(qp, infeasible=False)
        if found.x is None or found.z is None or found.z_box is None:
            return nothing(qp, infeasible=not found.found)
        multipliers = two_sided(qp, n + low, n + high, found.z)
        multipliers[:n] = found.z_box
        return QpAnswer(False, found.x, multipliers)

    return solve


def two_sided(qp: Qp, low: Ints, high: Ints, nonnegative: Array) -> Array:
    """One multiplier per row from those of the lower limits `low`, then of the upper ones `high`."""
    multipliers = np.zeros(len(qp.lower))
    multipliers[low] -= nonnegative[: len(low)]
    multipliers[high] += nonnegative[len(low) :]
    return multipliers


class RepeatedQp:
    """A QP (1) solved again and again with other upper limits, by daqp with its workspace kept.

    Attributes:
        usable: False when daqp refuses the problem, which then must not be solved.
    """

    def __init__(self, qp: Qp) -> None:
        import daqp

        self._model = daqp.Model()
        self._model.settings = {**self._model.settings, "primal_tol": 0.1 * ACCURACY}
        sense = np.zeros(len(qp.lower), dtype=np.intc)
        flag, _ = self._model.setup(qp.H, qp.f, qp.A, qp.upper, qp.lower, sense)
        self.usable = bool(flag >= 0) and len(qp.f) > 0
        self._lower = qp.lower

    def solve(self, upper: Array) -> QpAnswer:
        """The answer with upper limits (n + m,)."""
        self._model.update(bupper=upper, blower=self._lower)
        y, _, flag, info = self._model.solve()
        return QpAnswer(flag == DAQP_INFEASIBLE, y, info["lam"])


DIRECT: dict[str, Backend] = {
    "daqp": solve_daqp,
    "proxqp": solve_proxqp,
    "osqp": solve_osqp,
    "quadprog": solve_quadprog,
}
LIBRARY = {"daqp": "daqp", "proxqp": "proxsuite", "osqp": "osqp", "quadprog": "quadprog"}
