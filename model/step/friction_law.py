"""Coulomb friction at the unit columns of a step.

The unit column of a contact has three rows, its gap and its slip along two tangents, and the forces on them
lie in its cone, |λ_t| ≤ μ λ_n. Cables at a position and columns of a contact basis are contacts without
friction, whose tangents have neither motion nor force.

Unit columns join as they do without friction, where a candidate is too deep: one without force breaks the law
of friction exactly where it penetrates, and the natural map of its cone is then its depth within a factor
1 + μ². So one rule counts for normal and tangential forces.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tauten.model.friction import (
    PROJECTIONS,
    Cones,
    FrictionCertificate,
    FrictionProblem,
    NewtonForces,
    certify_friction,
    error_of,
    moving_contacts,
    newton_forces,
    newton_round,
    padded_places,
    padded_rows,
)
from tauten.model.numerics import Array, Bools, Ints, kernel
from tauten.model.step.compliance import Compliance
from tauten.model.step.condensed_step import NO_AXES, CondensedStep
from tauten.model.step.enrichment import PredictedStep
from tauten.model.step.forces import Forces

QUICK = PROJECTIONS // 20  # of the certificate that a node computes between two ticks
TOLERANCE = 1e-9  # of the natural map, relative to the largest row value
LEAST = 1e-13  # m, the same where all row values are small
ACCEPTED = 1e-8  # m, of an answer that does not become better; as deep as pointwise contact may be
BUDGET = 40  # Newton steps of an attempt
CLIMB, ROUGH = 9, 1e-5  # shares of the friction on the way from none, and tolerance there
SOFTNESS = 1e-6  # compliance that contacts have where no forces solve the problem, of their own
SOFT_STEPS = 60  # Newton steps of that problem
WORSE = 2.0  # times the error, up to which its forces are preferred
NO_FORCES = np.zeros((0, 3))
CLOSINGS = 10  # times that contacts join because they close


@kernel
def cone_forces(W: Array, delta: Array, friction: Array, start: Array) -> tuple[Array, float, bool]:
    """Forces (m,) on cables at a position, columns of a basis, and unit columns with friction.

    Args:
        W: (m, m) compliance between these rows [m/N].
        delta: (m,) their values without forces [m].
        friction: (r,) coefficients of the contacts with friction, whose rows are the last ones.
        start: (m,) forces to start from [N].

    Returns:
        The forces [N]; the residual of the natural map [m], +inf where W or the row values are not finite;
        whether it is within the tolerance: not where there is no solution.
    """
    rows = len(delta)
    if not (np.isfinite(W).all() and np.isfinite(delta).all()):
        return np.zeros(rows), np.inf, False
    every, place = padded_rows(W, delta, friction), padded_places(rows, len(friction))
    first = np.zeros(len(every.q))
    for i in range(rows):
        first[place[i]] = start[i] if np.isfinite(start[i]) else 0.0
    moves = every.W_ii > 0.0  # others are on what is fixed
    if not moves.any():
        residual = max(np.max(-delta), 0.0)
        return np.zeros(rows), residual, residual == 0.0
    at_moving = _rows_of(moves)
    if len(at_moving) < len(first):
        every = _chosen(every, moves, at_moving)
    r, error, converged = _closed(every, first[at_moving])
    first[:] = 0.0
    first[at_moving] = r
    return first[place], error, converged


@kernel
def _rows_of(contacts: Bools) -> Ints:
    """The rows of some contacts, three each."""
    rows, count = np.empty(3 * len(contacts), np.int64), 0
    for i in range(len(contacts)):
        if contacts[i]:
            for j in range(3):
                rows[count + j] = 3 * i + j
            count += 3
    return rows[:count]


@kernel
def _chosen(cones: Cones, contacts: Bools, rows: Ints) -> Cones:
    """Some of the contacts alone, with these rows."""
    W = np.empty((len(rows), len(rows)))
    for i in range(len(rows)):
        for j in range(len(rows)):
            W[i, j] = cones.W[rows[i], rows[j]]
    return Cones(W, cones.q[rows], cones.mu[contacts], cones.W_ii[contacts])


@kernel
def _closed(cones: Cones, start: Array) -> tuple[Array, float, bool]:
    """Forces (3 k,), error of the natural map [m], and whether it is small enough.

    Contacts that neither had a force nor close are left out until they close: W is singular where contacts
    are more than the unknowns, and few of them take part.

    Args:
        cones: all contacts.
        start: (3 k,) forces to start from [N].
    """
    enough = max(TOLERANCE * np.abs(cones.q).max(), LEAST)
    r, error = start, error_of(cones, start)
    use = np.zeros(len(cones.mu), np.bool_)
    for _ in range(CLOSINGS):
        if error <= enough:
            break
        values, more = np.dot(cones.W, r) + cones.q, False
        for i in range(len(use)):
            if not use[i] and (r[3 * i] > 0.0 or values[3 * i] < -enough):
                use[i] = more = True
        if not more:
            break
        rows = _rows_of(use)
        found = _climbed(_chosen(cones, use, rows), r[rows], enough)
        r = np.zeros_like(start)
        r[rows] = found
        error = error_of(cones, r)
    return r, error, error <= max(enough, ACCEPTED)


@kernel
def _climbed(cones: Cones, start: Array, enough: float) -> Array:
    """Forces (3 k,): from those of the last step, or where that fails along growing friction from none.

    Args:
        cones: the contacts that take part.
        start: (3 k,) forces to start from [N].
        enough: error that is small enough [m].
    """
    largest = np.abs(cones.q).max()
    if not largest > 0.0:
        enough = 0.0
    found = newton_forces(cones, start, enough, enough, BUDGET, False)
    if found.error <= max(enough, ACCEPTED):
        return found.r
    climbed = NewtonForces(np.zeros_like(start), np.inf, 0, 0)
    for step in range(CLIMB):
        share = step / (CLIMB - 1)
        part = Cones(cones.W, cones.q, share * cones.mu, cones.W_ii)
        limit = enough if step == CLIMB - 1 else ROUGH * largest
        climbed = newton_forces(part, climbed.r, limit, limit, BUDGET, False)
    best = climbed if climbed.error < found.error else found
    return best.r if best.error <= max(enough, ACCEPTED) else _softened(cones, best, enough)


@kernel
def _softened(cones: Cones, best: NewtonForces, enough: float) -> Array:
    """Forces (3 k,) where Newton's steps have failed: exact ones from a start with soft contacts, or these.

    Contacts that are jammed between obstacles which close have no solution, and forces that Newton's steps
    leave may be of any size. Those of contacts that are slightly soft are as small as the depth permits.

    Args:
        cones: the contacts that take part.
        best: the best forces so far.
        enough: error that is small enough [m].
    """
    none = np.zeros_like(best.r)
    soft, _, _ = newton_round(cones, none, SOFTNESS, 1.0, 0.0, SOFT_STEPS)
    again = newton_forces(cones, soft, enough, enough, BUDGET, False)
    if again.error <= max(enough, ACCEPTED):
        return again.r
    if error_of(cones, soft) <= WORSE * min(best.error, again.error):
        return soft
    return again.r if again.error < best.error else best.r


def unit_start(step: CondensedStep, previous: Forces) -> Array:
    """Forces on rows of unit columns to start from: the last ones (3 r,) [N]; zero (r,) without friction."""
    if not step.frictional:
        return np.zeros(len(step.extra))
    across = NO_FORCES if previous.friction is None else previous.friction.force
    known = previous.extra, previous.extra_beta, across
    return _start_of(step.rows.contacts.slots[step.extra], step.axes, known)


@kernel
def _start_of(slots: Ints, axes: Array, known: tuple[Ints, Array, Array]) -> Array:
    """Forces (3 r,) that contacts had [N].

    Args:
        slots: (r,) of the contacts.
        axes: (r, 3, 3) directions of their rows.
        known: (p,) slots, (p,) normal forces and (p, 3) friction that are known; (0, 3): none is.
    """
    others, normal, across = known
    start = np.zeros(3 * len(slots))
    for k in range(len(slots)):
        for p in range(len(others)):
            if others[p] == slots[k]:
                start[3 * k] = normal[p]
                for t in range(1, 3 if len(across) > 0 else 1):
                    for i in range(3):
                        start[3 * k + t] += axes[k, t, i] * across[p, i]
    return start


def step_certificate(solved: PredictedStep, quickly: bool = False) -> FrictionCertificate | None:
    """The certificate of the contacts with friction of a solved step; None where none pushes.

    Its W is that under given efforts, so that forces are indeterminate where others give the same motion
    without a change of the efforts. Its error is that of all candidates in range: one without force has an
    error where it is predicted to penetrate. Quickly, contacts that are jammed are looked for with a
    twentieth of the projections.
    """
    step, projections = solved.step, QUICK if quickly else PROJECTIONS
    if not step.frictional or not solved.contacts_push:
        return None
    c = slice(step.layout.n_e + step.layout.n_a + len(step.reduced), None)
    W, r, delta = step.compliance.W[c, c], solved.lam[c], solved.delta[c]
    mu = step.rows.contacts.found.friction[step.extra]
    moves, rows = moving_contacts(W)
    W, r = W[rows[:, None], rows], r[rows]
    found = certify_friction(FrictionProblem(W, delta[rows] - W @ r, mu[moves]), r, projections)
    gaps = step.rows.contacts.rows.after(step.system.h, step.system.v + solved.dv)
    gaps[step.extra] = 0.0  # these are rows of the problem, or on what is fixed
    return replace(found, error=max(found.error, -float(gaps.min(initial=0.0))))


def under_friction(step: CondensedStep, previous: Forces) -> CondensedStep:
    """A step with the friction of the last step as a load, in which contacts have their normal row alone.

    It is returned as it is where no contact in range has friction.
    """
    if not step.frictional:
        return step
    known, system = step.compliance, step.system
    first = step.layout.n_e + step.layout.n_a + len(step.reduced)
    units = first + np.arange(len(known) - first)
    normal, across = units[::3], units.reshape(-1, 3)[:, 1:].ravel()
    kept = np.concatenate([np.arange(first), normal])
    load = unit_start(step, previous).reshape(-1, 3)[:, 1:].ravel()  # (2 r,) N
    compliance = Compliance(
        known.H[kept],
        known.Y[kept],
        known.W[kept[:, None], kept],
        known.delta_free[kept] + known.W[kept[:, None], across] @ load,
        known.halves,
    )
    v_free = system.v_free + system.h * known.pushed(load, across)
    pushed = replace(system, v_free=v_free)
    contacts = replace(step.rows.contacts, relative=None)
    rows = replace(step.rows, contacts=contacts)
    return replace(
        step, system=pushed, rows=rows, axes=NO_AXES, compliance=compliance, frictional=False,
        slid=None,
    )  # fmt: skip
