"""Problems without solution: limits that give way, the smallest forces of contacts before all others."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from tauten.controller.qpcc.problem import Qpcc
from tauten.controller.qpcc.solution import Solution, Status

APPROACHED = 100.0  # weight of smallest forces that give way against the target, by curvatures
SLACK = 1e-9  # of the value of a row, by which a relaxed limit exceeds it

Solve = Callable[[Qpcc, Solution | None], Solution]


def solve_relaxed(
    problem: Qpcc, solution: Solution, others: int, solve: Solve, elastic: tuple[Status, ...]
) -> tuple[Qpcc, Solution]:
    """Solve a problem that has no solution with relaxed limits; returns also the problem solved last.

    Args:
        problem: with its limits as they are; of those of contact forces the smallest ones give way first.
        solution: the answer to it, whose status is in `elastic`.
        others: number of the limits before these.
        solve: solves a problem, from the point that violates the limits least where that is known.
        elastic: statuses at which limits are relaxed.
    """
    wider, nearest = favouring_largest(problem, solution, others), solution
    if wider is not problem:
        nearest = solve(wider, solution)
    if wider is problem or nearest.status in elastic:
        wider = relaxed(wider, nearest)
        nearest = solve(wider, nearest)
    if nearest.status in elastic:
        return problem, solution
    if not nearest.status.usable:
        return wider, nearest
    return wider, replace(nearest, status=Status.RELAXED, conflict=solution.conflict)


def favouring_largest(problem: Qpcc, nearest: Solution, others: int) -> Qpcc:
    """A problem without solution whose smallest forces are approached instead of kept.

    The largest forces stay limits, so that of two that contradict each other the smallest one gives way.
    It is the problem itself where no largest force is exceeded.
    """
    reached = problem.G @ np.concatenate([nearest.lam_a, nearest.beta])  # (p,)
    short = reached < problem.g_lo - SLACK * np.abs(problem.g_lo)
    short[:others] = False
    beyond = reached > problem.g_hi + SLACK * np.abs(problem.g_hi)
    if not (short.any() and beyond[others:].any()):
        return problem
    rows, least = problem.G[short], problem.g_lo[short]
    weight = APPROACHED * np.trace(problem.Q) / np.square(rows).sum()
    return replace(
        problem,
        Q=problem.Q + weight * rows.T @ rows,
        c=problem.c - weight * least @ rows,
        constant=problem.constant + 0.5 * weight * float(least @ least),
        g_lo=np.where(short, -np.inf, problem.g_lo),
    )


def relaxed(problem: Qpcc, nearest: Solution) -> Qpcc:
    """A problem without solution with limits that are met by the point that violates them least."""
    reached = problem.G @ np.concatenate([nearest.lam_a, nearest.beta])  # (p,)
    slack = SLACK * np.abs(reached)
    return replace(
        problem,
        g_lo=np.minimum(problem.g_lo, reached - slack),
        g_hi=np.maximum(problem.g_hi, reached + slack),
    )
