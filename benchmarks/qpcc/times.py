"""How long QPCCs take, by size, start and QP library."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from time import perf_counter
from typing import Literal

import numpy as np

from benchmarks.qpcc.random_problems import robot_like
from tauten.controller.qpcc import Qpcc, QpccSettings, Solution, solve_qpcc
from tauten.service.replay import Spread, spread

STEPS = 20  # control steps of a random robot
FASTEST_OF = 5
LARGE = 100  # modes from which a problem is solved once only, and few problems are


@dataclass(frozen=True, slots=True)
class Size:
    """Cables, modes, and how many random robots of them are timed for how many control steps."""

    n_a: int
    k: int
    robots: int = 10
    steps: int = STEPS


SIZES = (
    *(Size(n_a, k) for n_a in (1, 3, 9) for k in (5, 10, 23, 40)),
    Size(12, 100, robots=4, steps=5),
    Size(40, 200, robots=2, steps=4),
)


Kind = Literal["descent", "cold", "warm"]


@dataclass(frozen=True, slots=True)
class StepProblem:
    """A problem of a control step, and the solution of the step before."""

    problem: Qpcc
    before: Solution


@dataclass(frozen=True, slots=True)
class SolveTimes:
    """Times of one size, start and library.

    Attributes:
        solver: QP library.
        n_a: cables.
        k: contact modes.
        start: "descent", from tensions of zero; "cold", with the homotopy as a second start; "warm", from the
            solution of the step before.
        problems: how many.
        ms: times of a solve; of every problem the fastest of some, so that the p99 is that of problems and
            not of other load on the machine.
        pivots: pieces solved.
        statuses: how often each status came.
    """

    solver: str
    n_a: int
    k: int
    start: str
    problems: int
    ms: Spread
    pivots: Spread
    statuses: dict[str, int]


def make_problems(size: Size) -> list[StepProblem]:
    """Control steps of random robots whose compliance drifts and whose target moves."""
    problems, n_a = [], size.n_a
    for seed in range(size.robots):
        robot = robot_like(np.random.default_rng(seed), n_a, size.k)
        free = robot.delta_free[3 : 3 + n_a]
        position, before = np.zeros(n_a), None
        for step in range(size.steps + 1):
            problem = robot.problem(step, position)
            solution = solve_qpcc(problem, before)
            if before is not None:
                problems.append(StepProblem(problem, before))
            if solution.status.usable:
                position = problem.G @ np.concatenate([solution.lam_a, solution.beta]) + free
                before = solution
            elif before is None:
                break  # without a solution of its first step a robot has no warm start
    return problems


def time_solves(
    problems: list[StepProblem], solver: str, kind: Kind, fastest_of: int
) -> SolveTimes:
    """Measure the time of all solves.

    Args:
        problems: the problems.
        solver: QP library of the pieces.
        kind: of start, see `SolveTimes`.
        fastest_of: solves of a problem, of which the fastest counts.
    """
    settings = QpccSettings(solver, second_start="cold" if kind == "cold" else "never")
    times, pivots = [], []
    statuses: Counter[str] = Counter()
    for one in problems:
        start = one.before if kind == "warm" else None
        fastest = np.inf
        for _ in range(fastest_of):
            begin = perf_counter()
            solution = solve_qpcc(one.problem, start, settings)
            fastest = min(fastest, perf_counter() - begin)
        times.append(1e3 * fastest)
        pivots.append(float(solution.pivots))
        statuses[solution.status.name] += 1
    return SolveTimes(
        solver=solver,
        n_a=len(problems[0].problem.lb),
        k=len(problems[0].problem.m),
        start=kind,
        problems=len(problems),
        ms=spread(times),
        pivots=spread(pivots),
        statuses=dict(statuses),
    )
