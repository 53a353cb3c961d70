"""How long QPCCs take, by size, start and QP library."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from tauten.controller.qpcc import Qpcc, QpccSettings, Solution, solve_qpcc
from tauten.service.bench.qpcc.random_problems import robot_like
from tauten.service.replay import Spread, spread

CABLES, MODES = (1, 3, 9), (5, 10, 23, 40)
ROBOTS, STEPS = 10, 20  # problems of a size: so many random robots, each for so many control steps
FASTEST_OF = 5


@dataclass(frozen=True, slots=True)
class Asked:
    """A problem of a control step, and the answer to the step before."""

    problem: Qpcc
    before: Solution


@dataclass(frozen=True, slots=True)
class SolveTimes:
    """Times of one size, start and library.

    Attributes:
        solver: QP library.
        n_a: cables.
        k: contact modes.
        start: "cold", without tension and force, or "warm", from the solution of the step before.
        problems: how many.
        ms: times of a solve; of every problem the fastest of some, so that the p99 is that of problems and
            not of whatever else the machine did.
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


def make_problems(n_a: int, k: int, robots: int = ROBOTS) -> list[Asked]:
    """Control steps of random robots whose compliance drifts and whose target moves."""
    asked = []
    for seed in range(robots):
        robot = robot_like(np.random.default_rng(seed), n_a, k)
        free = robot.response.delta_free[3 : 3 + n_a]
        pull, before = np.zeros(n_a), None
        for step in range(STEPS + 1):
            problem = robot.problem(step, pull)
            solution = solve_qpcc(problem, before)
            if before is not None:
                asked.append(Asked(problem, before))
            if solution.status.usable:
                pull = problem.G @ np.concatenate([solution.lam_a, solution.beta]) + free
                before = solution
            elif before is None:
                break  # a robot that cannot even start is no robot
    return asked


def time_solves(asked: list[Asked], solver: str, warm: bool, fastest_of: int) -> SolveTimes:
    """Solve all problems and look at the clock."""
    settings = QpccSettings(solver=solver)
    times, pivots = [], []
    statuses: Counter[str] = Counter()
    for one in asked:
        start = one.before if warm else None
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
        n_a=len(asked[0].problem.lb),
        k=len(asked[0].problem.m),
        start="warm" if warm else "cold",
        problems=len(asked),
        ms=spread(times),
        pivots=spread(pivots),
        statuses=dict(statuses),
    )
