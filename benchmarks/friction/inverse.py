"""Inverse control with Coulomb friction: random steps and physical cases with their best known objectives."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter, thread_time

import numpy as np

from benchmarks.friction.drift import DriftRun, drift
from benchmarks.friction.pressed import PressedRun, pressed_run
from benchmarks.friction.stored import (
    WARM,
    StoredInverse,
    read_inverse,
    read_reduced,
    solve_stored,
    violation,
)
from tauten.controller.friction import (
    FrictionInverse,
    FrictionSettings,
    normals_alone,
    solve_friction_inverse,
)
from tauten.controller.qpcc import Start, solve_qpcc
from tauten.model import one_blas_thread
from tauten.service.process import HostInfo, host_info

CUTS = (2, 4, 8)  # linear systems
DRIFTS = (
    "step_a3_c2_r19_001",
    "step_a3_c10_r24_003",
    "step_a9_c10_r24_012",
    "step_a3_c20_r47_003",
    "step_a9_c40_r47_003",
)
FEW_UNKNOWNS = "step_a9_c40_r47_003", 19  # a problem, and on how many unknowns it is reduced
ALMOST_NONE = 1e-9  # coefficient of friction that is to give the answer without friction


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
        ms: time on the clock [ms].
        cpu_ms: time of the thread [ms].
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
    cpu_ms: float
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
        drifts: 600 warm steps each.
        pressed: whole inverse steps of a finger that presses on a plate.
    """

    machine: HostInfo
    runs: tuple[InverseRun, ...]
    frictionless: tuple[float, ...]
    drifts: tuple[DriftRun, ...]
    pressed: tuple[PressedRun, ...]


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
        followed = [one for one in stored if one.name in DRIFTS]
        followed.append(read_reduced(folder, *FEW_UNKNOWNS))
        drifts = tuple(drift(one) for one in followed)
        pressed = (pressed_run("reduced"), pressed_run("full", 100))
    return InverseFrictionBench(host_info(), tuple(runs), tuple(differences), drifts, pressed)


def inverse_run(stored: StoredInverse) -> InverseRun:
    """One problem: solved cold, warm, and cut."""
    begin, thread = perf_counter(), thread_time()
    found = solve_stored(stored, FrictionSettings())
    ms, cpu_ms = 1e3 * (perf_counter() - begin), 1e3 * (thread_time() - thread)
    warm = solve_stored(stored, WARM)
    cut = [solve_stored(stored, FrictionSettings(solves=solves)) for solves in CUTS]
    gained = found.objective < found.held
    return InverseRun(
        name=stored.name,
        n_a=len(stored.lam),
        contacts=len(stored.problem.friction),
        rank=stored.rank,
        excess=stored.excess(found.objective),
        stayed=not gained and stored.best < 0.9 * stored.held,
        error=found.error,
        violation=violation(stored, found),
        solves=found.solves,
        ms=ms,
        cpu_ms=cpu_ms,
        warm=(stored.excess(warm.objective), warm.solves),
        cut=(
            max(one.error for one in cut),
            max(violation(stored, one) for one in cut),
            max(one.objective / one.held for one in cut),
        ),
    )


def frictionless_difference(stored: StoredInverse) -> float:
    """Objective with next to no friction less that of the QPCC of the normals, relative to hold."""
    program = stored.problem.program
    problem = FrictionInverse(program, np.full(len(stored.problem.friction), ALMOST_NONE))
    found = solve_friction_inverse(problem, stored.lam)
    without = solve_qpcc(normals_alone(problem)[0], Start(stored.lam, stored.forces[::3] > 0.0))
    return (found.objective - without.objective) / found.held
