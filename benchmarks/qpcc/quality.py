"""How good QPCC solutions are: compared with global optima, with kept tensions, and by their certificates."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.qpcc.global_optimum import branch_and_bound
from benchmarks.qpcc.oracle import enumerate_pieces
from benchmarks.qpcc.random_problems import degenerate, known_global, known_stationary, robot_like
from benchmarks.qpcc.recorded import load_recorded
from tauten.controller.qpcc import (
    Qpcc,
    QpccSettings,
    Solution,
    Start,
    certify,
    read_qpcc,
    solve_qpcc,
)

ONE_START = QpccSettings(second_start="never")
KEPT_TENSIONS = QpccSettings(max_pivots=0, second_start="never")
SEARCH_TIME = 0.2  # s of branch and bound a problem, where the optimum is not known otherwise
ENUMERABLE = 7  # modes of which all pieces are enumerated
ROBOTS = (
    (1, 5, 150), (3, 10, 150), (3, 23, 150), (9, 23, 150), (9, 40, 150), (12, 100, 40),
)  # fmt: skip
TINY = 1e-300  # a best known objective may be zero
# Of an objective, relative to what it is with the tensions and forces of the start
ROUND_OFF = 1e-9


@dataclass(frozen=True, slots=True)
class QpccCase:
    """A problem, where a controller would start, and the optimum where it is known.

    Attributes:
        problem: the QPCC.
        start: of a controller; None: there is none.
        optimum: or the best known objective; None: to be searched for.
        slack: absolute difference of objectives that counts as none.
    """

    problem: Qpcc
    start: Start | None = None
    optimum: float | None = None
    slack: float = 0.0


@dataclass(frozen=True, slots=True)
class Gaps:
    """How far objectives lie above the optimum, relative.

    Attributes:
        start: "descent", from tensions of zero alone; "cold", with the homotopy as a second start; "warm",
            from the step before.
        exact: share within 1e-6.
        percent: share within 1 %.
        worst: largest; None when a problem with a feasible point was not solved.
        statuses: how often each status came.
    """

    start: str
    exact: float
    percent: float
    worst: float | None
    statuses: dict[str, int]


@dataclass(frozen=True, slots=True)
class Quality:
    """One set of problems.

    Attributes:
        name: of the set.
        problems: how many.
        empty: of them in which no feasible point was found, left out of the gaps.
        unproved: problems whose optimum was not proved in the time of branch and bound; the best known
            value counts.
        gaps: by start.
        residual: largest residual that `solve_qpcc` certifies in a solution that is OK.
        judged: largest primal or complementarity residual as judged independently of the solver.
        strong: share of the OK ones that are strongly stationary as judged independently; the rest was
            settled by solving all pieces that touch the point.
        stay: problems whose tensions before satisfy the limits.
        worse_than_staying: of them, solutions that are worse than these.
    """

    name: str
    problems: int
    empty: int
    unproved: int
    gaps: tuple[Gaps, ...]
    residual: float
    judged: float
    strong: float
    stay: int
    worse_than_staying: int


@dataclass(slots=True)
class _Tally:
    """Sums over a set."""

    excess: dict[str, list[float]]
    statuses: dict[str, Counter[str]]
    unproved: int = 0
    empty: int = 0
    residual: float = 0.0
    judged: float = 0.0
    ok: int = 0
    strong: int = 0
    stay: int = 0
    worse: int = 0


def generated(seed: int = 0) -> Iterator[tuple[str, list[QpccCase]]]:
    """The families of random problems, 1,000 and some in all."""
    rng = np.random.default_rng(seed)
    for n_a, k, count in ROBOTS:
        cases = [QpccCase(robot_like(rng, n_a, k).problem()) for _ in range(count)]
        yield f"robots {n_a} x {k}", cases
    cases = []
    for i in range(200):
        known = known_global(rng, *((1, 5), (3, 10), (9, 23), (9, 40))[i % 4], degenerate=i % 3)
        cases.append(
            QpccCase(known.problem, None, known.problem.objective(known.lam_a, known.beta))
        )
    yield "optimum known", cases
    yield (
        "many optima",
        [QpccCase(known_stationary(rng, 3, 7, degenerate=i % 3).problem) for i in range(150)],
    )
    yield "degenerate", [QpccCase(degenerate(rng, 1 + i % 3, 2 + i % 6)) for i in range(220)]


def recorded(folder: Path) -> Iterator[tuple[str, list[QpccCase]]]:
    """The recorded problems of a folder, file by file."""
    for file in sorted(folder.glob("*.npz")):
        cases = [QpccCase(step.problem(), step.start) for step in load_recorded(file)]
        yield file.stem, cases


def collections(folder: Path) -> Iterator[tuple[str, list[QpccCase]]]:
    """Published problems of a folder, with their best known objectives in problems.csv."""
    with (folder / "problems.csv").open(encoding="utf-8") as file:
        best = {row["name"]: float(row["best_known"]) for row in csv.DictReader(file)}
    cases = {
        name: QpccCase(read_qpcc(folder / f"{name}.npz")[0], None, value, slack=1e-6)
        for name, value in best.items()
    }
    yield "QPECs", [case for name, case in cases.items() if name.startswith("qpec-")]
    yield "MacMPEC LCQPs", [case for name, case in cases.items() if not name.startswith("qpec-")]


def measure(name: str, cases: list[QpccCase], progress: Callable[[], None]) -> Quality:
    """Solve a set of problems in all ways.

    Args:
        name: of the set.
        cases: the problems.
        progress: called after each problem.
    """
    kinds = ("descent", "cold", "warm") if cases[0].start else ("descent", "cold")
    tally = _Tally({kind: [] for kind in kinds}, {kind: Counter() for kind in kinds})
    for case in cases:
        solve_all_ways(case, kinds, tally)
        progress()
    return Quality(
        name=name,
        problems=len(cases),
        empty=tally.empty,
        unproved=tally.unproved,
        gaps=tuple(gaps_of(kind, tally) for kind in kinds),
        residual=tally.residual,
        judged=tally.judged,
        strong=tally.strong / max(tally.ok, 1),
        stay=tally.stay,
        worse_than_staying=tally.worse,
    )


def solve_all_ways(case: QpccCase, kinds: tuple[str, ...], tally: _Tally) -> None:
    """One problem: every start, the oracle, the judges.

    Args:
        case: the problem.
        kinds: of start, as in `Gaps`.
        tally: sums over the set, updated.
    """
    problem, start = case.problem, case.start
    solutions = {
        "descent": solve_qpcc(problem, None, ONE_START),
        "cold": solve_qpcc(problem),
    }
    if start is not None:
        solutions["warm"] = solve_qpcc(problem, start)
    for kind in kinds:
        tally.statuses[kind][solutions[kind].status.name] += 1
    best, proved = optimum(case, list(solutions.values()))
    tally.unproved += not proved
    if best == np.inf:
        tally.empty += 1
        return
    margin = ROUND_OFF * max(abs(problem.constant), abs(best))
    for kind in kinds:
        solution = solutions[kind]
        excess = solution.objective - best if solution.status.usable else np.inf
        excess = 0.0 if excess <= case.slack else excess
        relative = 0.0 if excess <= margin * 1e-3 else excess / max(abs(best), margin, TINY)
        tally.excess[kind].append(relative)
        inspect(problem, solution, tally)
    if start is not None:
        compare_with_kept_efforts(problem, start, solutions["warm"], tally)


def optimum(case: QpccCase, solutions: list[Solution]) -> tuple[float, bool]:
    """The lowest objective, +inf where no feasible point was found, and whether it is proved."""
    problem = case.problem
    found = [one.objective for one in solutions if one.status.usable]
    if case.optimum is not None:
        return case.optimum, True
    if len(problem.m) <= ENUMERABLE:
        return enumerate_pieces(problem)[0], True
    search = branch_and_bound(problem, case.start, SEARCH_TIME)
    return min([search.objective, *found]), search.proved


def inspect(problem: Qpcc, solution: Solution, tally: _Tally) -> None:
    """The residuals of a solution, by the solver and independently of it.

    Args:
        problem: the QPCC.
        solution: its solution.
        tally: sums over the set, updated.
    """
    if not solution.status.usable:
        return
    judged = certify(problem, solution.lam_a, solution.beta)
    tally.judged = max(tally.judged, judged.primal, judged.complementarity)
    if solution.status.ok:
        own = solution.certificate
        tally.residual = max(tally.residual, own.primal, own.complementarity, own.stationarity)
        tally.ok += 1
        tally.strong += judged.stationarity <= 1e-8


def compare_with_kept_efforts(problem: Qpcc, start: Start, warm: Solution, tally: _Tally) -> None:
    """Count solutions worse than the tensions before with the contact forces they cause.

    Args:
        problem: the QPCC.
        start: tensions and piece of the step before.
        warm: solution from this start.
        tally: sums over the set, updated.
    """
    stay = solve_qpcc(problem, start, KEPT_TENSIONS)
    if stay.status.usable:
        tally.stay += 1
        tally.worse += not warm.objective <= stay.objective * (1.0 + ROUND_OFF)


def gaps_of(kind: str, tally: _Tally) -> Gaps:
    """Shares of a start."""
    excess = np.array(tally.excess[kind])
    worst = float(excess.max(initial=0.0))
    return Gaps(
        start=kind,
        exact=float(np.mean(excess <= 1e-6)),
        percent=float(np.mean(excess <= 1e-2)),
        worst=worst if np.isfinite(worst) else None,
        statuses=dict(tally.statuses[kind]),
    )
