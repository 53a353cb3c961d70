"""Contact forces of a problem: Newton's steps, and where they fail a path through smoothed laws before them.

From zero most problems take ten Newton steps. Those whose contacts are highly redundant take hundreds or
never end; from the end of a path they take a few. One path in ten fails, mostly not the next one, which is
wider or narrower at first.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.friction.problem import Cones, FrictionProblem
from tauten.model.friction.proximal_newton import NewtonForces, newton_forces
from tauten.model.friction.smoothed_path import Width, smoothed_forces
from tauten.model.numerics import Array, Ints

TOLERANCE = 1e-9  # of the natural map, relative to the largest |q|
BUDGET = 1000  # linear systems
FIRST = 60  # Newton steps before a path
LAST = 40  # Newton steps from its end
LENGTHS = (0.1, 1.0, 0.3, 10.0, 0.03, 3.0)  # of the largest |q|: widths of the paths at first
SHRINK = 0.5  # of κ, after a full step of a path
PATH = 60  # steps of a path, at most


@dataclass(frozen=True, slots=True)
class FrictionSolution:
    """Contact forces with friction.

    Attributes:
        r: (m d,) forces.
        u: (m d,) velocities or displacements.
        error: of the natural map, in the unit of q; see `FrictionProblem.error`.
        newton: linear systems that were solved; a round without one counts as one.
        rounds: of the proximal point.
        converged: whether the error is within the tolerance.
    """

    r: Array
    u: Array
    error: float
    newton: int
    rounds: int
    converged: bool


def solve_friction(
    problem: FrictionProblem,
    start: Array | None = None,
    budget: int = BUDGET,
) -> FrictionSolution:
    """Solve contact with friction; the best forces found, whether they meet `TOLERANCE` or not.

    Args:
        problem: the contacts.
        start: (m d,) forces to start from, as of the last step; None: zero. They are returned where they
            hold.
        budget: linear systems, at most; beyond `FIRST` of them paths are tried.
    """
    first = np.zeros(len(problem.q)) if start is None else np.array(start, dtype=float)
    given = (problem.W, problem.q, problem.mu, problem.compliance)
    cones = Cones(*(np.ascontiguousarray(values, dtype=float) for values in given))
    error = TOLERANCE * float(np.abs(cones.q).max())
    found = newton_forces(cones, first, error, error, min(budget, FIRST), False)
    for length in LENGTHS:
        if found.error <= error or found.newton >= budget:
            break
        found = _lower(found, _along_path(cones, length, error, budget - found.newton))
    if found.error > error and found.newton < budget:
        rest = newton_forces(cones, found.r, error, error, budget - found.newton, False)
        found = _lower(found, rest)
    u = cones.W @ found.r + cones.q
    return FrictionSolution(
        found.r, u, found.error, found.newton, found.rounds, found.error <= error
    )


def _along_path(cones: Cones, length: float, error: float, budget: int) -> NewtonForces:
    """Forces by Newton's steps from the end of a path, which starts at zero."""
    d = len(cones.q) // len(cones.mu)
    spatial, rows = _spatial(cones) if d == 2 else (cones, np.arange(len(cones.q)))
    wide, none = Width(1.0, length * float(np.abs(cones.q).max()), SHRINK), np.zeros(len(spatial.q))
    forces = np.empty((len(none), 0))  # the system is that of the forces
    r, steps = smoothed_forces(spatial, forces, none, wide, min(PATH, budget))
    found = newton_forces(cones, r[rows], error, error, min(LAST, budget - steps), True)
    return found._replace(newton=steps + found.newton)


def _lower(known: NewtonForces, more: NewtonForces) -> NewtonForces:
    """The forces with the lower error of two; steps of both."""
    best = more if more.error < known.error else known
    return best._replace(newton=known.newton + more.newton, rounds=known.rounds + more.rounds)


def _spatial(cones: Cones) -> tuple[Cones, Ints]:
    """Contacts of two rows with a third, which has neither motion nor force; where the two are among them."""
    m = len(cones.mu)
    rows = (3 * np.arange(m)[:, None] + np.arange(2)).ravel()
    W, q = np.zeros((3 * m, 3 * m)), np.zeros(3 * m)
    W[rows[:, None], rows], q[rows] = cones.W, cones.q
    third = 3 * np.arange(m) + 2
    W[third, third] = cones.W_ii
    return Cones(W, q, cones.mu, cones.W_ii), rows
