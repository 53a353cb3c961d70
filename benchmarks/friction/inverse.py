"""Inverse control with Coulomb friction: random steps and physical cases with their best known objectives."""

from __future__ import annotations

import csv
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter

import numpy as np

from tauten.controller.friction import (
    FrictionInverse,
    FrictionSettings,
    InverseSolution,
    solve_friction_inverse,
)
from tauten.controller.qpcc import Qpcc, Start, solve_qpcc
from tauten.model.numerics import Array
from tauten.service.process import HostInfo, host_info, one_blas_thread

CUTS = (2, 4, 8)  # linear systems
WARM = FrictionSettings(warm=True, path_steps=25, forwards=1)
ALMOST_NONE = 1e-9  # coefficient of friction that is to give the answer without friction


@dataclass(frozen=True, slots=True)
class StoredInverse:
    """A stored problem.

    Attributes:
        name: of its file.
        problem: to solve.
        lam: (n_a,) efforts before the step.
        forces: (3 k,) contact forces before the step.
        held: objective of holding.
        best: lowest objective that is known.
    """

    name: str
    problem: FrictionInverse
    lam: Array
    forces: Array
    held: float
    best: float

    def excess(self, objective: float) -> float:
        """(f − f_best) / max(f_best, 0.01 f_hold)."""
        return (objective - self.best) / max(self.best, 0.01 * self.held)


@dataclass(frozen=True, slots=True)
class InverseRun:
    """One problem.

    Attributes:
        name: of its file.
        n_a: number of efforts.
        contacts: number of contacts.
        rank: of their compliance.
        excess: over the best known objective.
        stayed: whether hold was returned where a tenth could be gained.
        error: of the natural map.
        violation: of the limits.
        solves: linear systems.
        ms: time [ms].
        warm: excess and linear systems with one narrow path of 25 steps and one step of descent.
        cut: largest error, largest violation and largest objective relative to hold, of cut searches.
    """

    name: str
    n_a: int
    contacts: int
    rank: int
    excess: float
    stayed: bool
    error: float
    violation: float
    solves: int
    ms: float
    warm: tuple[float, int]
    cut: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class InverseFrictionBench:
    """All problems of a folder.

    Attributes:
        machine: facts about it.
        runs: one of each problem.
        frictionless: objectives with next to no friction less those of the QPCC without friction, relative
            to hold, one of each step.
    """

    machine: HostInfo
    runs: tuple[InverseRun, ...]
    frictionless: tuple[float, ...]


def read_inverse(folder: Path) -> list[StoredInverse]:
    """The problems of a folder with `problems.csv`; see the README beside it."""
    with (folder / "problems.csv").open() as table:
        return [_read(folder, row) for row in csv.DictReader(table)]


def _read(folder: Path, row: dict[str, str]) -> StoredInverse:
    with np.load(folder / f"{row['name']}.npz") as data:
        G_e, G_a, G_c = data["G_e"], data["G_a"], data["G_c"]
        weight, error = data["Q"], data["d0_e"] - data["target"]
        G = np.concatenate([G_a, G_c])
        E, n_a = G_e @ G.T, len(G_a)
        Q = (E.T * weight) @ E
        Q[:n_a, :n_a] += float(data["eps"]) * (G_a @ G_a.T)
        program = Qpcc(
            Q=Q,
            c=E.T @ (weight * error),
            lb=data["lam_min"],
            ub=data["lam_max"],
            G=G_a @ G.T,
            g_lo=data["delta_min"] - data["d0_a"],
            g_hi=data["delta_max"] - data["d0_a"],
            M=G_c @ G.T,
            m=data["d0_c"],
            constant=0.5 * float(weight @ error**2),
        )
        problem = FrictionInverse(program, data["mu"])
        known = float(row["f_hold"]), float(row["f_best"])
        return StoredInverse(row["name"], problem, data["lam_start"], data["r_start"], *known)


def solve_stored(stored: StoredInverse, settings: FrictionSettings) -> InverseSolution:
    """Solve a stored problem from what was before its step."""
    return solve_friction_inverse(stored.problem, stored.lam, stored.forces, settings)


def violation(stored: StoredInverse, found: InverseSolution) -> float:
    """By which an answer exceeds the limits at most, in their unit."""
    p = stored.problem.program
    rows = p.G @ np.concatenate([found.lam_a, found.forces])
    beyond = np.concatenate([rows - p.g_hi, p.g_lo - rows, found.lam_a - p.ub, p.lb - found.lam_a])
    return max(0.0, float(beyond.max()))


def bench_friction_inverse(
    folder: Path, progress: Callable[[float, str], None]
) -> InverseFrictionBench:
    """Solve all problems of a folder.

    Args:
        folder: of `.npz` files and `problems.csv`.
        progress: called with the share of the work that has just been done, and what comes next.
    """
    stored, runs, differences = read_inverse(folder), list[InverseRun](), list[float]()
    with one_blas_thread():
        solve_stored(stored[0], FrictionSettings())  # compiles
        for one in stored:
            runs.append(inverse_run(one))
            if one.name.startswith("step"):
                differences.append(frictionless_difference(one))
            progress(1.0 / len(stored), one.name)
    return InverseFrictionBench(host_info(), tuple(runs), tuple(differences))


def inverse_run(stored: StoredInverse) -> InverseRun:
    """One problem: solved cold, warm, and cut."""
    begin = perf_counter()
    found = solve_stored(stored, FrictionSettings())
    ms = 1e3 * (perf_counter() - begin)
    warm = solve_stored(stored, WARM)
    cut = [solve_stored(stored, FrictionSettings(solves=solves)) for solves in CUTS]
    program = stored.problem.program
    gained = found.objective < found.held
    return InverseRun(
        name=stored.name,
        n_a=len(stored.lam),
        contacts=len(stored.problem.friction),
        rank=int(np.linalg.matrix_rank(program.M[:, len(stored.lam) :], tol=1e-9)),
        excess=stored.excess(found.objective),
        stayed=not gained and stored.best < 0.9 * stored.held,
        error=found.error,
        violation=violation(stored, found),
        solves=found.solves,
        ms=ms,
        warm=(stored.excess(warm.objective), warm.solves),
        cut=(
            max(one.error for one in cut),
            max(violation(stored, one) for one in cut),
            max(one.objective / one.held for one in cut),
        ),
    )


def frictionless_difference(stored: StoredInverse) -> float:
    """Objective with next to no friction less that of the QPCC of the normals, relative to hold."""
    program, n_a = stored.problem.program, len(stored.lam)
    problem = FrictionInverse(program, np.full(len(stored.problem.friction), ALMOST_NONE))
    found = solve_friction_inverse(problem, stored.lam)
    z = np.concatenate([np.arange(n_a), n_a + np.arange(0, len(program.m), 3)])
    normal = replace(
        program,
        Q=program.Q[z[:, None], z],
        c=program.c[z],
        G=program.G[:, z],
        M=program.M[::3][:, z],
        m=program.m[::3],
    )
    without = solve_qpcc(normal, Start(stored.lam, stored.forces[::3] > 0.0))
    return (found.objective - without.objective) / found.held
