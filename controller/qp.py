"""One convex QP, and the only module that names a QP library.

    min 1/2 y'Hy + f'y   subject to   lower <= (y, A y) <= upper                       (1)

The first n entries of `lower`, `upper` bound the variables, the others the rows of A. Entries beyond
±UNBOUNDED are no bounds. The QPs of a QPCC are tiny (n <= 10, m <= 60) and solved thousands of times a
second, so that setting up and wrapping cost more than the iterations: `daqp`, `proxqp`, `osqp` and
`quadprog` are called directly, any other solver that qpsolvers finds goes through its wrapper.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from tauten.model.arrays import Array

UNBOUNDED = 1e30
ACCURACY = 1e-10  # primal and dual, on QPs whose variables and Hessian are of order one


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
    """What a back end found.

    Attributes:
        solved: False when it is infeasible or the back end gave up; y is then not to be used.
        y: (n,).
        multipliers: (n + m,), Hy + f + (I, A')·multipliers = 0; positive at upper, negative at lower.
    """

    solved: bool
    y: Array
    multipliers: Array


Backend = Callable[[Qp], QpAnswer]


def available_backends() -> tuple[str, ...]:
    """Names that `qp_backend` accepts on this machine, the default first."""
    import qpsolvers

    direct = [name for name in DIRECT if importlib.util.find_spec(LIBRARY[name]) is not None]
    return tuple(direct + [name for name in qpsolvers.dense_solvers if name not in direct])


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


def failed(qp: Qp) -> QpAnswer:
    """The answer of a back end that found nothing."""
    return QpAnswer(False, np.zeros(len(qp.f)), np.zeros(len(qp.lower)))


def solve_daqp(qp: Qp) -> QpAnswer:
    """Dual active set (Arnström, Bemporad, Axehill 2022): exact up to round-off."""
    import daqp

    y, _, flag, info = daqp.solve(qp.H, qp.f, qp.A, qp.upper, qp.lower, primal_tol=ACCURACY)
    return QpAnswer(flag > 0, y, info["lam"])


def solve_proxqp(qp: Qp) -> QpAnswer:
    """Augmented Lagrangian with an active-set flavour (Bambade et al. 2022), dense."""
    from proxsuite import proxqp

    n, m = len(qp.f), len(qp.lower) - len(qp.f)
    solver = proxqp.dense.QP(n, 0, m, True)
    solver.settings.eps_abs = ACCURACY
    solver.settings.eps_rel = 0.0
    lower, upper = qp.lower, qp.upper
    solver.init(qp.H, qp.f, None, None, qp.A, lower[n:], upper[n:], lower[:n], upper[:n])
    solver.solve()
    solved = solver.results.info.status == proxqp.PROXQP_SOLVED
    z = solver.results.z
    return QpAnswer(solved, solver.results.x, np.concatenate([z[m:], z[:m]]))


def solve_osqp(qp: Qp) -> QpAnswer:
    """Operator splitting (Stellato et al. 2020) with its polishing step."""
    import osqp
    import scipy.sparse as sp

    n = len(qp.f)
    solver = osqp.OSQP()
    rows = sp.csc_matrix(np.vstack([np.eye(n), qp.A]))
    solver.setup(
        sp.csc_matrix(np.triu(qp.H)),
        qp.f,
        rows,
        qp.lower,
        qp.upper,
        eps_abs=1e-9,
        eps_rel=1e-9,
        max_iter=20_000,
        polishing=True,
        verbose=False,
    )
    result = solver.solve(raise_error=False)
    return QpAnswer(result.info.status_val == 1, result.x, result.y)


def solve_quadprog(qp: Qp) -> QpAnswer:
    """Goldfarb and Idnani (1983); H must be positive definite."""
    import quadprog

    rows = np.vstack([np.eye(len(qp.f)), qp.A])
    low = np.flatnonzero(qp.lower > -UNBOUNDED)
    high = np.flatnonzero(qp.upper < UNBOUNDED)
    C = np.vstack([rows[low], -rows[high]])
    b = np.concatenate([qp.lower[low], -qp.upper[high]])
    try:
        y, _, _, _, lagrangian, _ = quadprog.solve_qp(qp.H, -qp.f, np.ascontiguousarray(C.T), b)
    except ValueError:
        return failed(qp)
    multipliers = np.zeros(len(qp.lower))
    multipliers[low] -= lagrangian[: len(low)]
    multipliers[high] += lagrangian[len(low) :]
    return QpAnswer(True, y, multipliers)


def wrapped(name: str) -> Backend:
    """Any dense solver of qpsolvers, through its wrapper."""

    def solve(qp: Qp) -> QpAnswer:
        import qpsolvers

        n = len(qp.f)
        lower = np.where(qp.lower <= -UNBOUNDED, -np.inf, qp.lower)
        upper = np.where(qp.upper >= UNBOUNDED, np.inf, qp.upper)
        low, high = np.flatnonzero(lower[n:] > -np.inf), np.flatnonzero(upper[n:] < np.inf)
        problem = qpsolvers.Problem(
            P=qp.H,
            q=qp.f,
            G=np.vstack([-qp.A[low], qp.A[high]]),
            h=np.concatenate([-lower[n:][low], upper[n:][high]]),
            lb=lower[:n],
            ub=upper[:n],
        )
        try:
            found = qpsolvers.solve_problem(problem, solver=name)
        except (qpsolvers.exceptions.QPError, ValueError, ArithmeticError):
            return failed(qp)
        if not found.found or found.x is None or found.z is None or found.z_box is None:
            return failed(qp)
        multipliers = np.zeros(len(qp.lower))
        multipliers[:n] = found.z_box
        multipliers[n + low] -= found.z[: len(low)]
        multipliers[n + high] += found.z[len(low) :]
        return QpAnswer(True, found.x, multipliers)

    return solve


class RepeatedQp:
    """A QP (1) solved again and again with other upper limits, by daqp with its workspace kept."""

    def __init__(self, qp: Qp) -> None:
        import daqp

        self._model = daqp.Model()
        self._model.settings = {**self._model.settings, "primal_tol": 0.1 * ACCURACY}
        sense = np.zeros(len(qp.lower), dtype=np.intc)
        self._model.setup(qp.H, qp.f, qp.A, qp.upper, qp.lower, sense)
        self._lower = qp.lower

    def solve(self, upper: Array) -> tuple[bool, float, Array]:
        """Whether it is solved, the optimal value, y (n,)."""
        self._model.update(bupper=upper, blower=self._lower)
        y, value, flag, _ = self._model.solve()
        return flag > 0, value, y


DIRECT: dict[str, Backend] = {
    "daqp": solve_daqp,
    "proxqp": solve_proxqp,
    "osqp": solve_osqp,
    "quadprog": solve_quadprog,
}
LIBRARY = {"daqp": "daqp", "proxqp": "proxsuite", "osqp": "osqp", "quadprog": "quadprog"}
