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

from tauten.model.friction import FrictionProblem, solve_friction
from tauten.model.numerics import Array, Ints
from tauten.model.step.condensed_step import CondensedStep
from tauten.model.step.forces import Forces

TOLERANCE = 1e-9  # of the natural map, relative to the largest row value
LEAST = 1e-13  # m, the same where all row values are small


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


@dataclass(frozen=True, slots=True)
class PaddedRows:
    """Rows as contacts of three rows each.

    Attributes:
        W: (3 k, 3 k) compliance [m/N].
        q: (3 k,) row values without forces [m].
        mu: (k,) coefficients of friction.
        place: (m,) where each row is among them.
    """

    W: Array
    q: Array
    mu: Array
    place: Ints


def padded_rows(W: Array, delta: Array, friction: Array) -> PaddedRows:
    """Rows of single contacts, then three of each contact with friction, as contacts of three rows each.

    A single row gets two more, with its own compliance and neither motion nor friction.

    Args:
        W: (s + 3 r, s + 3 r) compliance [m/N].
        delta: (s + 3 r,) row values without forces [m].
        friction: (r,) coefficients of friction.
    """
    s = len(delta) - 3 * len(friction)
    place = np.concatenate([3 * np.arange(s), np.arange(3 * s, 2 * s + len(delta))])
    padded, q = np.zeros((2 * s + len(delta),) * 2), np.zeros(2 * s + len(delta))
    padded[place[:, None], place] = W
    q[place] = delta
    more = np.concatenate([place[:s] + 1, place[:s] + 2])
    padded[more, more] = np.tile(np.diag(W)[:s], 2)
    return PaddedRows(padded, q, np.concatenate([np.zeros(s), friction]), place)


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
    moves = np.diag(rows.W).reshape(-1, 3).max(axis=1) > 0.0
    if not moves.any():
        residual = float(np.maximum(-delta, 0.0).max())
        return FrictionForces(np.zeros_like(delta), residual, residual == 0.0)
    kept = np.flatnonzero(np.repeat(moves, 3))
    problem = FrictionProblem(rows.W[kept[:, None], kept], rows.q[kept], rows.mu[moves])
    largest = float(np.abs(problem.q).max())
    tolerance = max(TOLERANCE, LEAST / largest) if largest > 0.0 else TOLERANCE
    found = solve_friction(problem, first[kept], tolerance)
    if not found.converged and first.any():
        again = solve_friction(problem, None, tolerance)
        found = again if again.error < found.error else found
    lam = np.zeros(len(rows.q))
    lam[kept] = found.r
    return FrictionForces(lam[rows.place], found.error, found.converged)


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
        across = np.einsum("rti,ri->rt", found.tangents()[step.extra], friction.force[at])
        r[:, 1:] = np.where(same[:, None], across, 0.0)
    return r.ravel()
