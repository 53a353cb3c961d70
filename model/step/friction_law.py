"""Coulomb friction at the unit columns of a step.

The unit column of a contact has three rows, its gap and its slip along two tangents, and the forces on them
lie in its cone, |λ_t| ≤ μ λ_n. Cables at a position and columns of a contact basis are contacts without
friction, whose tangents have neither motion nor force.

Unit columns join as they do without friction, where a candidate is too deep: one without force breaks the law
of friction exactly where it penetrates, and the natural map of its cone is then its depth within a factor
1 + μ². So one rule counts for normal and tangential forces.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.friction import FrictionProblem, moving_contacts, padded_rows, solve_friction
from tauten.model.numerics import Array
from tauten.model.step.condensed_step import CondensedStep
from tauten.model.step.forces import Forces

TOLERANCE = 1e-9  # of the natural map, relative to the largest row value
LEAST = 1e-13  # m, the same where all row values are small
ACCEPTED = 1e-8  # m, of an answer that does not become better; as deep as pointwise contact may be
BUDGET = 40  # Newton steps of an attempt
CLIMB, ROUGH = 9, 1e-5  # shares of the friction on the way from none, and tolerance there
CLOSINGS = 10  # times that contacts join because they close


@dataclass(frozen=True, slots=True)
class FrictionForces:
    """Solution of contacts with friction and of cables.

    Attributes:
        lam: (m,) forces [N].
        residual: of the natural map [m]; +inf where W or the row values are not finite.
        converged: whether it is within the tolerance.
    """

    lam: Array
    residual: float
    converged: bool


def friction_forces(step: CondensedStep, W: Array, delta: Array, start: Array) -> FrictionForces:
    """Forces on cables at a position, columns of a basis, and unit columns with friction.

    Never raises: where there is no solution, `converged` is False.

    Args:
        step: whose unit columns are the last rows.
        W: (m, m) compliance between these rows [m/N].
        delta: (m,) their values without forces [m].
        start: (m,) forces to start from [N].
    """
    if not (np.isfinite(W).all() and np.isfinite(delta).all()):
        return FrictionForces(np.zeros_like(delta), np.inf, False)
    rows = padded_rows(W, delta, step.rows.contacts.found.friction[step.extra])
    first = np.zeros(len(rows.q))
    first[rows.place] = np.where(np.isfinite(start), start, 0.0)
    moves, kept = moving_contacts(rows.W)
    if not moves.any():
        residual = float(np.maximum(-delta, 0.0).max())
        return FrictionForces(np.zeros_like(delta), residual, residual == 0.0)
    problem = FrictionProblem(rows.W[kept[:, None], kept], rows.q[kept], rows.mu[moves])
    r, error, converged = _solved(problem, first[kept])
    lam = np.zeros(len(rows.q))
    lam[kept] = r
    return FrictionForces(lam[rows.place], error, converged)


def _solved(problem: FrictionProblem, start: Array) -> tuple[Array, float, bool]:
    """Forces (3 k,), error of the natural map [m], and whether it is small enough.

    Contacts that neither had a force nor close are left out until they close: W is singular where contacts
    are more than the unknowns, and few of them take part.

    Args:
        problem: all contacts.
        start: (3 k,) forces to start from [N].
    """
    largest = float(np.abs(problem.q).max())
    enough = max(TOLERANCE * largest, LEAST)
    r, error = start, problem.error(start)
    use = np.zeros(len(problem.mu), np.bool_)
    for _ in range(CLOSINGS):
        if error <= enough:
            break
        gaps = (problem.W @ r + problem.q)[::3]
        closing = ~use & ((r[::3] > 0.0) | (gaps < -enough))
        if not closing.any():
            break
        use |= closing
        rows = np.flatnonzero(np.repeat(use, 3))
        chosen = FrictionProblem(problem.W[rows[:, None], rows], problem.q[rows], problem.mu[use])
        found = _climbed(chosen, r[rows], enough)
        r = np.zeros_like(start)
        r[rows] = found
        error = problem.error(r)
    return r, error, error <= max(enough, ACCEPTED)


def _climbed(problem: FrictionProblem, start: Array, enough: float) -> Array:
    """Forces (3 k,): from those of the last step, or where that fails along growing friction from none.

    Args:
        problem: the contacts that take part.
        start: (3 k,) forces to start from [N].
        enough: error that is small enough [m].
    """
    largest = float(np.abs(problem.q).max())
    tolerance = enough / largest if largest > 0.0 else TOLERANCE
    found = solve_friction(problem, start, tolerance, BUDGET)
    if found.converged or found.error <= ACCEPTED:
        return found.r
    r: Array | None = None
    for share in np.linspace(0.0, 1.0, CLIMB):
        part = FrictionProblem(problem.W, problem.q, share * problem.mu)
        climbed = solve_friction(part, r, tolerance if share == 1.0 else ROUGH, BUDGET)
        r = climbed.r
    return climbed.r if climbed.error < found.error else found.r


def unit_start(step: CondensedStep, previous: Forces) -> Array:
    """Forces on the rows of the unit columns to start from: those of the last step (3 r,) [N].

    Without friction they are zero (r,).

    Args:
        step: the step.
        previous: forces of the last step.
    """
    if not step.frictional:
        return np.zeros(len(step.extra))
    r = np.zeros((len(step.extra), 3))
    found, friction = step.rows.contacts.found, previous.friction
    slots, known = found.slots[step.extra], np.argsort(previous.extra)
    if len(known) == 0:
        return r.ravel()
    at = known[np.minimum(np.searchsorted(previous.extra, slots, sorter=known), len(known) - 1)]
    same = previous.extra[at] == slots
    r[:, 0] = np.where(same, previous.extra_beta[at], 0.0)
    if friction is not None:
        across = np.einsum("rti,ri->rt", found.tangents(step.extra), friction.force[at])
        r[:, 1:] = np.where(same[:, None], across, 0.0)
    return r.ravel()
