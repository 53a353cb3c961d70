"""Published problems of contact with friction: errors, Newton steps, times, and projected Gauss-Seidel."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import numpy as np
from scipy.sparse import csr_array

from benchmarks.friction.admm import AdmmRun, admm, pinocchio_is_installed
from tauten.model import one_blas_thread
from tauten.model.friction import FrictionProblem, certify_friction, solve_friction
from tauten.model.numerics import Array
from tauten.service.process import HostInfo, host_info

SWEEPS = 1000  # of Gauss-Seidel over all contacts
REPEATS = 5  # of a timed solution, at most
LONGEST = 2.0  # s, of the repeats of a problem


@dataclass(frozen=True, slots=True)
class FrictionRun:
    """One problem.

    Attributes:
        name: of its file.
        contacts: number of contacts.
        dim: rows of a contact.
        closed: contacts that push.
        sticking: contacts that stick.
        indeterminate: whether other forces give the same motion.
        newton: linear systems solved from a cold start.
        rounds: of the proximal point.
        error: of the natural map, relative to the largest |q|.
        siconos_error: as Siconos measures it.
        ms: time from a cold start, the least of some [ms].
        warm: linear systems solved from this solution after q has changed by 0.1 %.
        sweeps_error: of projected Gauss-Seidel after its sweeps, relative to the largest |q|.
        admm: Pinocchio's ADMM; None where it is not installed, or a contact has two rows.
    """

    name: str
    contacts: int
    dim: int
    closed: int
    sticking: int
    indeterminate: bool
    newton: int
    rounds: int
    error: float
    siconos_error: float
    ms: float
    warm: int
    sweeps_error: float
    admm: AdmmRun | None


@dataclass(frozen=True, slots=True)
class FrictionBench:
    """All problems of a folder.

    Attributes:
        machine: facts about it.
        sweeps: of Gauss-Seidel.
        runs: one of each problem.
    """

    machine: HostInfo
    sweeps: int
    runs: tuple[FrictionRun, ...]


def read_problem(file: Path) -> FrictionProblem:
    """A problem of a file with W (CSR), q and mu; see the README beside it."""
    with np.load(file) as data:
        parts = data["W_data"], data["W_indices"], data["W_indptr"]
        W: Array = csr_array(parts, tuple(data["W_shape"])).toarray()
        return FrictionProblem(W, data["q"].astype(float), data["mu"].astype(float))


def bench_friction(folder: Path, progress: Callable[[float, str], None]) -> FrictionBench:
    """Solve all problems of a folder.

    Args:
        folder: of `.npz` files.
        progress: called with the share of the work that has just been done, and what comes next.
    """
    files = sorted(folder.glob("*.npz"))
    runs = list[FrictionRun]()
    with one_blas_thread():
        for file in files:
            runs.append(_run(file.stem, read_problem(file)))
            progress(1.0 / len(files), file.stem)
    return FrictionBench(host_info(), SWEEPS, tuple(runs))


def _run(name: str, problem: FrictionProblem) -> FrictionRun:
    """One problem, cold and warm."""
    solution, times = solve_friction(problem), list[float]()
    while len(times) < REPEATS and sum(times) < LONGEST:
        begin = perf_counter()
        solve_friction(problem)
        times.append(perf_counter() - begin)
    changed = FrictionProblem(problem.W, 1.001 * problem.q, problem.mu)
    found, largest = certify_friction(problem, solution.r), float(np.abs(problem.q).max())
    return FrictionRun(
        name=name,
        contacts=len(problem.mu),
        dim=problem.dim,
        closed=int(found.closed.sum()),
        sticking=int(found.sticking.sum()),
        indeterminate=found.indeterminate,
        newton=solution.newton,
        rounds=solution.rounds,
        error=solution.error / largest,
        siconos_error=siconos_error(problem, solution.r),
        ms=1e3 * min(times),
        warm=solve_friction(changed, solution.r).newton,
        sweeps_error=problem.error(gauss_seidel(problem, SWEEPS)) / largest,
        admm=admm(problem) if problem.dim == 3 and pinocchio_is_installed() else None,
    )


def siconos_error(problem: FrictionProblem, r: Array) -> float:
    """Error as Siconos measures it: ‖r − P_K(r − û)‖ / max(‖q‖, ‖r‖, ‖u‖).

    Args:
        problem: the contacts.
        r: (m d,) forces.
    """
    u, shape = problem.W @ r + problem.q, (len(problem.mu), problem.dim)
    z = (r - u).reshape(shape)
    z[:, 0] -= problem.mu * np.linalg.norm(u.reshape(shape)[:, 1:], axis=1)
    away = r.reshape(shape) - projected(z, problem.mu)
    largest = max(float(np.linalg.norm(one)) for one in (problem.q, r, u))
    return float(np.linalg.norm(away)) / largest


def projected(z: Array, mu: Array) -> Array:
    """Projection of z (m, d) on the cones |z_t| ≤ μ z_n, with mu (m,)."""
    length = np.linalg.norm(z[:, 1:], axis=1)  # (m,)
    outside = length > mu * z[:, 0]
    normal = np.maximum(z[:, 0] + mu * length, 0.0) / (1.0 + mu * mu)
    share = mu * normal / np.where(length > 0.0, length, 1.0)
    onto = np.column_stack([normal, share[:, None] * z[:, 1:]])
    found: Array = np.where(outside[:, None], onto, z)
    return found


def gauss_seidel(problem: FrictionProblem, sweeps: int) -> Array:
    """Contact forces (m d,) after sweeps of projected Gauss-Seidel over the contacts, from zero.

    Args:
        problem: the contacts.
        sweeps: their number; fewer where they take longer than `LONGEST`.
    """
    d, r, W_ii = problem.dim, np.zeros_like(problem.q), problem.compliance
    end = perf_counter() + LONGEST
    for _ in range(sweeps):
        for i, mu in enumerate(problem.mu):
            rows = slice(i * d, (i + 1) * d)
            u = problem.W[rows] @ r + problem.q[rows]
            u[0] += mu * np.linalg.norm(u[1:])
            z = r[rows] - u / W_ii[i]
            r[rows] = projected(z[None], np.array([mu]))[0]
        if perf_counter() > end:
            break
    return r
