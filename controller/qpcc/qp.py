"""One convex QP, and the only module that names a QP library.

    min 1/2 y'Hy + f'y   subject to   lower <= (y, A y) <= upper                       (5)

The first n entries of `lower`, `upper` bound the variables, the others the rows of A. Entries beyond
±UNBOUNDED are no bounds. The QPs of a QPCC are small (n <= 10, m <= 60 as a rule) and solved thousands of
times a second, so that setting up and wrapping cost more than the iterations: daqp is called directly, other
libraries through qpsolvers, and a function of somebody else as it is. Their answers are taken as they are;
what these are good for, the residuals of the solution say.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

import daqp
import numpy as np
from scipy.sparse import csc_matrix

from tauten.model import answer_of, shape_fault
from tauten.model.load import extension, extension_names
from tauten.model.numerics import Array
from tauten.model.schema import RobotFileError

GROUP = "tauten.qp_solvers"  # of entry points
UNBOUNDED = 1e30
# A QP whose variables are of order one has no minimum where its answer is this large
ENDLESS = 1e12
ACCURACY = 1e-10  # residual that daqp may leave, on QPs whose variables are of order one
# Of daqp: the curvature that a singular Hessian borrows, where its proximal iteration stops, and components
# of a step that count as zero. Where larger ones do, it calls a QP with nearly redundant contacts infeasible.
DAQP = {"primal_tol": ACCURACY, "eps_prox": -1e-4, "eta_prox": ACCURACY, "zero_tol": 1e-14}
# Where that was too coarse: variables of one part of a robot may be that small beside those of another. Not
# at once, because a few QPs with nearly redundant rows would be called infeasible.
FINEST = {**DAQP, "primal_tol": 1e-12}
# Where rows are nearly redundant, as those of two cables beside each other: with the others such a QP may be
# called infeasible that is not.
REDUNDANT = {**DAQP, "primal_tol": 1e-8, "eps_prox": -1e-2, "sing_tol": 1e-14}
ROUNDING = 1e-13  # of the largest singular value, what counts as none
DAQP_INFEASIBLE = -1  # exit flag
# Libraries whose own tolerances are far above what a piece needs.
OPTIONS: dict[str, dict[str, Any]] = {
    "osqp": {"eps_abs": 1e-9, "eps_rel": 1e-9, "max_iter": 10_000},
    "proxqp": {"eps_abs": 1e-9, "eps_rel": 0.0, "max_iter": 1_000},
}


@dataclass(frozen=True, slots=True)
class Qp:
    """Problem (5).

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
    """The answer of a library.

    Attributes:
        infeasible: the library reports that there is no feasible point; y is then not to be used.
        y: (n,).
        multipliers: (n + m,) Hy + f + (I, A')·multipliers = 0; positive at upper, negative at lower.
    """

    infeasible: bool
    y: Array
    multipliers: Array


Backend = Callable[[Qp], QpAnswer]


def answer_fault(qp: Qp, found: object) -> str:
    """What is wrong with an answer to a QP; "" where nothing is."""
    if not isinstance(found, QpAnswer):
        return f"gives a {type(found).__name__}, expected is a QpAnswer"
    multipliers = "multipliers", found.multipliers, qp.lower.shape
    return shape_fault(("y", found.y, qp.f.shape), multipliers)


@dataclass(frozen=True, slots=True)
class AddedBackend:
    """A backend of another package.

    Attributes:
        name: of its entry point.
        solve: the function of the package.
    """

    name: str
    solve: Callable[[Qp], object]

    def __call__(self, qp: Qp) -> QpAnswer:
        """Solve a problem.

        Raises:
            ExtensionError: the function has failed, or has given no answer of the right shapes.
        """
        answer = answer_of(f"QP solver {self.name!r}", partial(answer_fault, qp), self.solve, qp)
        assert isinstance(answer, QpAnswer)
        return answer


def available_backends() -> tuple[str, ...]:
    """Names that `qp_backend` accepts on this machine: the default, entry points, libraries of qpsolvers."""
    import qpsolvers

    others = (*extension_names(GROUP), *qpsolvers.available_solvers)
    return tuple(dict.fromkeys(("daqp", *others)))


def qp_backend(solver: str | Backend) -> Backend:
    """The function that solves (5).

    Args:
        solver: the function itself; it never raises. Or its name: "daqp", an entry point of the group
            "tauten.qp_solvers", or a library that qpsolvers knows.

    Raises:
        RobotFileError: the library is not installed or unknown.
        TypeError: it is neither.
    """
    if isinstance(solver, str):
        return _named(solver)
    if not callable(solver):
        raise TypeError(f"solver: expected a name or a function, found {type(solver).__name__}")
    return solver


@cache
def _named(name: str) -> Backend:
    added: Backend | None = extension(GROUP, name, {"daqp": solve_daqp})
    if added is not None:
        return added if added is solve_daqp else AddedBackend(name, added)
    known = available_backends()
    if name not in known:
        raise RobotFileError(f"QP solver {name!r} is not installed, found are {', '.join(known)}")
    return through_qpsolvers(name)


def solve_daqp(qp: Qp, settings: Mapping[str, float] = DAQP) -> QpAnswer:
    """Dual active set (Arnström, Bemporad, Axehill 2022): exact up to round-off.

    Args:
        qp: the problem.
        settings: of the library.
    """
    if len(qp.f) == 0:
        return QpAnswer(False, np.zeros(0), np.zeros(len(qp.lower)))
    y, _, flag, info = daqp.solve(qp.H, qp.f, qp.A, qp.upper, qp.lower, **settings)
    # where there is no minimum the multipliers are memory that was not written
    multipliers = info["lam"] if flag > 0 else np.zeros(len(qp.lower))
    return QpAnswer(flag == DAQP_INFEASIBLE, y, multipliers)


def solve_redundant(qp: Qp) -> QpAnswer:
    """A QP with nearly redundant rows or variables: coarse, and then exact on the limits that hold.

    Args:
        qp: the problem.
    """
    answer, n = solve_daqp(qp, REDUNDANT), len(qp.f)
    (held,) = np.nonzero(answer.multipliers)
    if len(held) == 0:  # also where it is not solved
        return answer
    C = np.vstack([np.eye(n), qp.A])[held]
    limits = np.where(answer.multipliers > 0.0, qp.upper, qp.lower)[held]
    slope = qp.H @ answer.y + qp.f + C.T @ answer.multipliers[held]
    system = np.block([[qp.H, C.T], [C, np.zeros((len(held), len(held)))]])
    try:
        step = np.linalg.lstsq(system, np.concatenate([-slope, limits - C @ answer.y]), ROUNDING)[0]
    except np.linalg.LinAlgError:
        return answer
    multipliers = answer.multipliers.copy()
    multipliers[held] += step[n:]
    return QpAnswer(False, answer.y + step[:n], multipliers)


def through_qpsolvers(name: str) -> Backend:
    """Any other library, through the interface of qpsolvers."""

    def solve(qp: Qp) -> QpAnswer:
        import qpsolvers

        n, multipliers = len(qp.f), np.zeros(len(qp.lower))
        if n == 0:
            return QpAnswer(False, np.zeros(0), multipliers)
        low = np.flatnonzero(qp.lower[n:] > -UNBOUNDED)
        high = np.flatnonzero(qp.upper[n:] < UNBOUNDED)
        G = np.vstack([-qp.A[low], qp.A[high]])
        h = np.concatenate([-qp.lower[n:][low], qp.upper[n:][high]])
        lb = np.where(qp.lower[:n] <= -UNBOUNDED, -np.inf, qp.lower[:n])
        ub = np.where(qp.upper[:n] >= UNBOUNDED, np.inf, qp.upper[:n])
        dense = name in qpsolvers.dense_solvers
        matrix = np.asarray if dense else csc_matrix
        problem = qpsolvers.Problem(matrix(qp.H), qp.f, matrix(G), h, lb=lb, ub=ub)
        try:
            with warnings.catch_warnings():  # an empty piece is no news
                warnings.simplefilter("ignore")
                found = qpsolvers.solve_problem(problem, name, **OPTIONS.get(name, {}))
        except (qpsolvers.exceptions.QPError, ValueError, ArithmeticError):
            return QpAnswer(True, np.zeros(n), multipliers)
        if found.x is None or found.z is None or found.z_box is None:
            return QpAnswer(True, np.zeros(n), multipliers)
        multipliers[:n] = found.z_box
        multipliers[n + low] -= found.z[: len(low)]
        multipliers[n + high] += found.z[len(low) :]
        return QpAnswer(False, found.x, multipliers)

    return solve


class KeptQp:
    """A QP (5) solved again and again with another linear term, by daqp with its workspace kept.

    Attributes:
        usable: False when daqp refuses the problem, which then must not be solved.
    """

    def __init__(self, qp: Qp) -> None:
        self._model = daqp.Model()
        self._model.settings = {**self._model.settings, **DAQP}
        sense = np.zeros(len(qp.lower), dtype=np.intc)
        flag, _ = self._model.setup(qp.H, qp.f, qp.A, qp.upper, qp.lower, sense)
        self.usable = bool(flag >= 0) and len(qp.f) > 0

    def solve(self, f: Array) -> tuple[bool, Array]:
        """Whether there is a minimum with the linear term f (n,), and where."""
        self._model.update(f=f)
        y, _, flag, _ = self._model.solve()
        return bool(flag > 0 and np.abs(y).max() < ENDLESS), y
