"""Closed loop: a target that efforts can reach moves slowly, and each step starts from the last answer."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from time import perf_counter, thread_time

import numpy as np

from benchmarks.friction.stored import WARM, StoredInverse
from tauten.controller.friction import FrictionInverse, solve_friction_inverse
from tauten.model.friction import FrictionProblem, solve_friction
from tauten.model.numerics import Array

STEPS = 600
PERIOD = 300  # steps, in which the first effort goes to another value and back
WIDE = 0.3  # of the range of the efforts, about how far they go
EFFORT = 1e-6  # weight of efforts, of their curvature
PUSHES = 1e-9  # of the largest displacement, what a force pushes by that counts


@dataclass(frozen=True, slots=True)
class DriftRun:
    """The steps of one problem; medians and 99 % are of all steps.

    Attributes:
        name: of the problem's file.
        n_a: number of efforts.
        contacts: number of contacts.
        rank: of their compliance.
        pushing: contacts that push, mean.
        solves: linear systems of a step, median and 99 %.
        cpu_ms: time of the thread, median and 99 % [ms].
        wall_ms: time on the clock, median and 99 % [ms].
        error: RMS distance from the target, of the RMS distance of the target from its mean.
        inexact: largest error of the natural map.
    """

    name: str
    n_a: int
    contacts: int
    rank: int
    pushing: float
    solves: tuple[float, float]
    cpu_ms: tuple[float, float]
    wall_ms: tuple[float, float]
    error: float
    inexact: float


def drift(stored: StoredInverse, steps: int = STEPS) -> DriftRun:
    """Follow a target, each step from the answer of the last.

    Slip is counted from the last step, as in a control loop, so that what a step does depends on all before.

    Args:
        stored: the problem whose target moves.
        steps: how many.
    """
    problem, lam, forces = stored.problem, stored.lam, stored.forces
    w, E = np.diag(problem.program.M[:, len(lam) :]), stored.effectors
    largest = float(np.abs(problem.program.m).max())
    rows, way = list[tuple[float, ...]](), list[Array]()
    for target in reached(stored, steps):
        problem = towards(problem, stored, target)
        cpu, wall = thread_time(), perf_counter()
        found = solve_friction_inverse(problem, lam, forces, WARM)
        cpu, wall = thread_time() - cpu, perf_counter() - wall
        lam, forces = found.lam_a, found.forces
        z = np.concatenate([lam, forces])
        pushing, missed = (
            (w * forces > PUSHES * largest)[::3].sum(),
            stored.weight @ (E @ z - target) ** 2,
        )
        rows.append((found.solves, 1e3 * cpu, 1e3 * wall, pushing, missed, found.error))
        way.append(target)
        problem = moved_on(problem, z)
    numbers, ways = np.array(rows), np.array(way)
    spread = ((ways - ways.mean(axis=0)) ** 2 @ stored.weight).mean()
    return DriftRun(
        name=stored.name,
        n_a=len(lam),
        contacts=len(problem.friction),
        rank=stored.rank,
        pushing=float(numbers[:, 3].mean()),
        solves=_middle_and_end(numbers[:, 0]),
        cpu_ms=_middle_and_end(numbers[:, 1]),
        wall_ms=_middle_and_end(numbers[:, 2]),
        error=float(np.sqrt(numbers[:, 4].mean() / spread)),
        inexact=float(numbers[:, 5].max()),
    )


def reached(stored: StoredInverse, steps: int) -> Iterator[Array]:
    """Where effectors (n_e,) get under efforts that move slowly, step by step; E z, without their offset.

    Args:
        stored: the problem.
        steps: how many.
    """
    problem, n_a, r = stored.problem, len(stored.lam), stored.forces
    program = problem.program
    there = np.random.default_rng(0).uniform(program.lb, program.ub)
    for step in range(1, steps + 1):
        turns = (1 + np.arange(n_a) % 3) * step / PERIOD
        share = WIDE * 0.5 * (1.0 - np.cos(2.0 * np.pi * turns))
        lam = stored.lam + share * (there - stored.lam)
        q = problem.program.m + program.M[:, :n_a] @ lam
        r = solve_friction(FrictionProblem(program.M[:, n_a:], q, problem.friction), r).r
        z = np.concatenate([lam, r])
        yield stored.effectors @ z
        problem = moved_on(problem, z)


def moved_on(problem: FrictionInverse, z: Array) -> FrictionInverse:
    """The problem of the next step, whose slip begins where the last one ended.

    Args:
        problem: of the last step.
        z: (n_a + 3 k,) efforts and contact forces at its end.
    """
    program = problem.program
    normal = np.arange(len(program.m)) % 3 == 0
    m = np.where(normal, program.m, -program.M @ z)
    return replace(problem, program=replace(program, m=m))


def towards(problem: FrictionInverse, stored: StoredInverse, target: Array) -> FrictionInverse:
    """A problem with another target, and next to no weight on efforts, which would keep it from the target.

    Args:
        problem: the problem.
        stored: where it comes from.
        target: (n_e,) of the effectors, without their offset.
    """
    E, n_a = stored.effectors, problem.n_a
    Q = (E.T * stored.weight) @ E
    Q[:n_a, :n_a] += EFFORT * Q.diagonal()[:n_a].max() * np.eye(n_a)
    c, constant = -E.T @ (stored.weight * target), 0.5 * float(stored.weight @ target**2)
    return replace(problem, program=replace(problem.program, Q=Q, c=c, constant=constant))


def _middle_and_end(values: Array) -> tuple[float, float]:
    return float(np.median(values)), float(np.percentile(values, 99))
