"""One forward step: given positions or efforts of the actuators, what moves and what touches.

A cable wound to a length obeys the same law as a contact: its path may be shorter than the winch allows
but never longer, and it only pulls, 0 ≤ δ_a − pull ⟂ λ_a ≥ 0. One LCP contains both. Actuators that pull and
push, δ_a = pull, are eliminated from it: with their rows E and the others I,

    λ_E = W_EE⁻¹ (pull_E − δ_E − W_EI λ_I),   W_II − W_IE W_EE⁻¹ W_EI   instead of W_II        (T8)
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tauten.model.numerics import Array, Bools, Ints, kernel, lcp_forces
from tauten.model.signals import Command
from tauten.model.step.condensed_step import CondensedStep
from tauten.model.step.enrichment import Enrichment, PredictedStep, predict
from tauten.model.step.forces import Forces
from tauten.model.step.friction_law import cone_forces, unit_start
from tauten.model.step.sorted_rows import sort_rows, sorted_rows

# Eigenvalue of the scaled W_EE, relative to the largest, below which it is rounding.
SINGULAR = 1e-12
EQUAL = 1e-7  # of the terms of a row that is to be zero; what is left of it


@dataclass(frozen=True, slots=True)
class Elimination:
    """Rows without those that are to be zero.

    Attributes:
        W: (k, k) compliance between the rows that are kept.
        delta: (k,) their values without forces.
        gain: (e, k) and
        offset: (e,) forces of the other rows, gain λ_kept + offset.
    """

    W: Array
    delta: Array
    gain: Array
    offset: Array


def eliminate_rows(W: Array, delta: Array, kept: Ints, zero: Ints) -> Elimination:
    """Eliminate rows that are to be zero whatever the sign of their force, (T8).

    Args:
        W: (m, m) compliance [m/N].
        delta: (m,) row values without forces [m].
        kept: (k,) rows that stay.
        zero: (e,) rows that are to be zero.
    """
    diagonal = np.diag(W)[zero]
    scale = np.divide(1.0, np.sqrt(diagonal), out=np.zeros_like(diagonal), where=diagonal > 0.0)
    values, vectors = np.linalg.eigh(scale[:, None] * W[zero[:, None], zero] * scale)
    large = values > SINGULAR * values.max(initial=0.0)
    basis = scale[:, None] * vectors[:, large]
    inverse = (basis / values[large]) @ basis.T  # (e, e)
    cross = W[zero[:, None], kept]  # (e, k)
    gain, offset = -inverse @ cross, -inverse @ delta[zero]
    W_kept = W[kept[:, None], kept] + cross.T @ gain
    return Elimination(0.5 * (W_kept + W_kept.T), delta[kept] + cross.T @ offset, gain, offset)


def forward_step(
    step: CondensedStep, enrichment: Enrichment, previous: Forces, command: Command
) -> PredictedStep:
    """Solve a step under a command, positions or efforts; the LCP starts at the forces of the last one."""
    left = enrichment.rounds
    # A given effort is that of its row, whatever was added along it.
    if step.rho is not None and step.system.stiffened is not None:
        step = replace(step, rho=np.where(command.by_force, 0.0, step.rho))
    lam = known_forces(step, previous)
    while True:
        start = np.zeros(len(step.compliance.delta_free))
        start[: len(lam)] = lam
        lam, residual, converged = solve_forces(step, start, command)
        found = predict(step, enrichment, lam, left > 0, residual, converged)
        if isinstance(found, PredictedStep):
            return found
        step, left = found, left - 1


def known_forces(step: CondensedStep, previous: Forces) -> Array:
    """Forces of the last step on the rows of this one: (m,) [N]."""
    layout, lam = step.layout, np.zeros(len(step.compliance.delta_free))
    lam[layout.actuators] = previous.effort
    first = layout.n_e + layout.n_a + len(step.reduced.modes)
    lam[layout.n_e + layout.n_a : first] = previous.beta[step.reduced.modes]
    if len(step.extra) > 0:
        lam[first:] = unit_start(step, previous)
    return lam


def solve_forces(step: CondensedStep, start: Array, command: Command) -> tuple[Array, float, bool]:
    """Forces (m,) on all rows, complementarity residual [m], convergence.

    Args:
        step: system, rows and compliance.
        start: (m,) forces to start from [N].
        command: position or effort of each actuator.
    """
    W, free = step.compliance.W, step.compliance.delta_free
    known, bilateral = (command.position, command.effort), step.laws.bilateral
    friction = step.friction if step.rows.contacts.frictional else None
    lam = np.zeros(len(free))
    done, residual, converged = _unilateral_forces(
        W, free, known, bilateral, step.layout.n_e, start, friction, lam
    )
    if done:
        return lam, residual, converged
    rows = sorted_rows(step, command)
    kept, zero, delta = rows.unilateral, rows.equal, rows.under_effort(W)
    lam[rows.forced] = rows.effort
    rest = eliminate_rows(W, delta, kept, zero)
    found, none = np.zeros(len(kept)), np.zeros(0)  # all rows that are left push only
    _, residual, converged = _unilateral_forces(
        rest.W, rest.delta, (none, none), bilateral[:0], 0, start[kept], friction, found
    )
    lam[kept], lam[zero] = found, rest.gain @ found + rest.offset
    solved = np.concatenate([kept, zero])
    moved = W[zero[:, None], solved] * lam[solved]  # (e, k + e)
    left = np.abs(delta[zero] + moved.sum(axis=1))
    terms = np.abs(free[zero]) + np.abs(delta[zero]) + np.abs(moved).sum(axis=1)  # (e,)
    equal = bool((left <= EQUAL * terms).all())
    return lam, residual, converged and equal


@kernel
def _unilateral_forces(
    W: Array, free: Array, given: tuple[Array, Array], bilateral: Bools, n_e: int, start: Array,
    friction: Array | None, lam: Array,
) -> tuple[bool, float, bool]:  # fmt: skip
    """`solve_forces` in one kernel where no row is to be zero; whether that is so comes first.

    Args:
        W: (m, m) compliance [m/N].
        free: (m,) row values without forces [m].
        given: (n_a,) positions and efforts, NaN where not.
        bilateral: (n_a,) actuators that pull and push.
        n_e: effector rows, which come first.
        start: (m,) forces to start from [N].
        friction: (r,) coefficients of the contacts with friction, whose rows are the last ones; None for a
            robot without friction, whose kernel is compiled without that law.
        lam: (m,) zeros, overwritten with the forces.
    """
    forced, effort, equal, kept, _, delta = sort_rows(free, given[0], given[1], bilateral, n_e)
    k = len(kept)
    if len(equal) > 0:
        return False, 0.0, False
    lam[forced] = effort
    if len(forced) > 0:
        delta = delta + np.dot(W[:, forced], effort)
    W_kept = np.empty((k, k))
    for i in range(k):
        for j in range(k):
            W_kept[i, j] = W[kept[i], kept[j]]
    lam[kept], residual, converged = _pushing_forces(W_kept, delta[kept], friction, start[kept])
    return True, residual, converged


@kernel
def _pushing_forces(
    W: Array, delta: Array, friction: Array | None, start: Array
) -> tuple[Array, float, bool]:
    """Forces on cables at a position and on contacts, as `cone_forces`, also where none has friction."""
    if friction is not None and len(friction) > 0:  # left out of the kernel where it is None
        return cone_forces(W, delta, friction, start)
    lam, _, residual, _, converged = lcp_forces(W, delta, start)
    return lam, residual, converged
