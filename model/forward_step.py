"""One forward step: given tensions or pulled lengths, what moves and what touches.

A cable wound to a length obeys the same law as a contact: it may be shorter than its winch allows
but never longer, and it only pulls, 0 ≤ δ_a − pull ⟂ λ_a ≥ 0. One LCP holds both.

Contact forces live in a space λ_c = Ψ β (18). After the solve the gaps of *all* candidates in
range are predicted; where they violate the tolerance, unit columns are added to Ψ for this step and
the LCP is solved again. With an empty Ψ and a tight tolerance the same loop solves full pointwise
contact and never forms the columns of candidates that do not push.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from tauten.model.compliance import Compliance, extended, row_compliance
from tauten.model.contact_space import ContactSpace, EmptySpace
from tauten.model.numerics import Array, Ints, solve_lcp
from tauten.model.robot import Robot, RobotRows, State
from tauten.model.rows import ContactRows, dense
from tauten.model.system import Integration, System


@dataclass(frozen=True, slots=True)
class CableCommand:
    """What the winches do: hold tensions [N] or pulled lengths [m], (n_a,)."""

    tension: Array | None = None
    pull: Array | None = None


@dataclass(frozen=True, slots=True)
class Enrichment:
    """When and how unit columns join the contact space.

    Attributes:
        tolerance: predicted penetration that is accepted [m].
        rounds: how often columns may be added in one step; 0 switches enrichment off.
        per_pair: columns a round may add for each contact pair.
    """

    tolerance: float
    rounds: int
    per_pair: int


def default_enrichment(tolerance: float) -> Enrichment:
    """Modes carry the contacts; the worst candidate of a pair joins where they leave it too deep.

    Args:
        tolerance: penetration that is accepted, the robot file's [m].
    """
    return Enrichment(tolerance, rounds=3, per_pair=1)


# Pointwise contact: columns are added until no candidate is deeper than this [m].
POINTWISE = Enrichment(tolerance=1e-8, rounds=60, per_pair=8)
NO_ENRICHMENT = Enrichment(tolerance=np.inf, rounds=0, per_pair=0)


@dataclass(frozen=True, slots=True)
class Forces:
    """Constraint forces of a step.

    Attributes:
        tension: (n_a,) [N].
        beta: (k,) coefficients of the space's columns [N].
        extra: (r,) slots of the unit columns in play.
        extra_beta: (r,) their forces [N].
    """

    tension: Array
    beta: Array
    extra: Ints
    extra_beta: Array

    @property
    def pushed(self) -> Ints:
        """Slots of the unit columns that pushed."""
        return self.extra[self.extra_beta > 0.0]


@dataclass(frozen=True, slots=True)
class ForwardStep:
    """A solved forward step.

    Attributes:
        dv: (n,) velocity change [m/s].
        forces: constraint forces.
        pull: (n_a,) predicted pulled lengths [m].
        deepest_gap: smallest predicted gap [m], +inf without any candidate in range.
        residual: complementarity of the LCP [m].
        converged: whether LCP and enrichment met their tolerances.
    """

    dv: Array
    forces: Forces
    pull: Array
    deepest_gap: float
    residual: float
    converged: bool


def contact_model(
    contact: Literal["none", "full"] | ContactSpace, n_c: int, reduced: Enrichment
) -> tuple[ContactSpace, Enrichment]:
    """What "none", "full" or a basis means: the columns to start from and when others join.

    Args:
        contact: "none"; "full", pointwise; or a basis of contact forces.
        n_c: candidates of the robot.
        reduced: enrichment that goes with a basis.

    Raises:
        ValueError: `contact` is none of these, or a basis with another number of slots.
    """
    if contact == "none":
        return EmptySpace(n_c), NO_ENRICHMENT
    if contact == "full":
        return EmptySpace(n_c), POINTWISE
    if isinstance(contact, str):
        raise ValueError(f'contact is {contact!r}, allowed are "none", "full" or a basis')
    slots = len(contact.lift(np.zeros(contact.k)))
    if slots != n_c:
        raise ValueError(f"the contact basis has {slots} slots, the robot {n_c} candidates")
    return contact, reduced


def no_forces(n_a: int, k: int) -> Forces:
    """Forces of a robot at rest: n_a cables, k columns."""
    return Forces(np.zeros(n_a), np.zeros(k), np.zeros(0, dtype=np.int64), np.zeros(0))


def worst_rows(contacts: ContactRows, gaps: Array, enrichment: Enrichment, known: Ints) -> Ints:
    """Numbers of the rows that violate the tolerance most, up to `per_pair` of each pair: (r,).

    Args:
        contacts: candidates in range.
        gaps: (m,) their predicted gaps [m].
        enrichment: tolerance and how many.
        known: slots that have a unit column already.
    """
    if not gaps.min(initial=np.inf) < -enrichment.tolerance:  # nearly always
        return np.zeros(0, dtype=np.int64)
    bad = np.flatnonzero((gaps < -enrichment.tolerance) & ~np.isin(contacts.slots, known))
    order = bad[np.argsort(gaps[bad], kind="stable")]
    pair = contacts.pair[order]
    rank = np.zeros(len(order), dtype=np.int64)  # place of each among the bad ones of its pair
    for p in np.unique(pair):
        rank[pair == p] = np.arange(int((pair == p).sum()))
    return np.sort(order[rank < enrichment.per_pair])


def forward_step(
    robot: Robot,
    state: State,
    space: ContactSpace,
    command: CableCommand,
    enrichment: Enrichment,
    previous: Forces,
    integration: Integration | None = None,
) -> tuple[System, ForwardStep]:
    """Solve one step from `state` under `command`; the state is left as it is.

    Args:
        robot: whose factorisation workspace is used.
        state: where the step starts.
        space: columns of the contact forces.
        command: tensions or pulled lengths.
        enrichment: when unit columns are added.
        previous: forces of the last step: curvature of the cables, start of the unit columns.
        integration: another scheme than the robot's own.

    Raises:
        FactorisationError: the state has blown up.
    """
    system = robot.linearise(state, previous.tension, integration)
    rows = robot.rows(state, contacts=space.k > 0 or enrichment.rounds > 0)
    reduced = space.reduce(rows.contacts)
    # unit columns that pushed in the last step start in play
    chosen = rows.contacts.rows_of(previous.pushed)
    response = condense(system, rows, reduced.H, reduced.delta, chosen)
    k = robot.n_a + len(reduced)
    lam = np.concatenate([previous.tension, previous.beta[reduced.modes], np.zeros(len(chosen))])
    for round_ in range(enrichment.rounds + 1):
        lam, residual, ok = solve_forces(response, robot.n_a, command, lam)
        dv = response.velocity_change(system, lam)
        gaps = rows.contacts.rows.after(system.h, system.v + dv)
        worst = worst_rows(rows.contacts, gaps, enrichment, rows.contacts.slots[chosen])
        if len(worst) == 0 or round_ == enrichment.rounds:
            break
        response = extended(system, response, *unit_rows(rows.contacts, worst))
        chosen, lam = np.concatenate([chosen, worst]), np.append(lam, np.zeros(len(worst)))
    beta = np.zeros(space.k)
    beta[reduced.modes] = lam[robot.n_a : k]
    delta_a = response.delta_free[: robot.n_a] + response.W[: robot.n_a] @ lam
    return system, ForwardStep(
        dv=dv,
        forces=Forces(lam[: robot.n_a], beta, rows.contacts.slots[chosen], lam[k:]),
        pull=delta_a,
        deepest_gap=float(gaps.min(initial=np.inf)),
        residual=residual,
        converged=ok and len(worst) == 0,
    )


def unit_rows(contacts: ContactRows, chosen: Ints) -> tuple[Array, Array]:
    """Dense H (r, n) and gaps (r,) of single candidates."""
    return dense(contacts.rows.H[chosen]), contacts.rows.delta[chosen]


def condense(system: System, rows: RobotRows, H: Array, delta: Array, chosen: Ints) -> Compliance:
    """Compliance of cables, reduced contacts and chosen unit columns, in this order."""
    H_unit, delta_unit = unit_rows(rows.contacts, chosen)
    return row_compliance(
        system,
        np.vstack([rows.actuators.dense(), H, H_unit]),
        np.concatenate([rows.actuators.delta, delta, delta_unit]),
    )


def solve_forces(
    response: Compliance, n_a: int, command: CableCommand, start: Array
) -> tuple[Array, float, bool]:
    """Forces under a command, the complementarity residual [m], and convergence.

    Args:
        response: compliance of cables, modes and unit columns, in this order.
        n_a: number of cables.
        command: tensions or pulled lengths.
        start: (m,) forces to start from.
    """
    W, delta = response.W, response.delta_free.copy()
    if command.pull is not None:
        delta[:n_a] -= command.pull
        result = solve_lcp(W, delta, start)
        return result.lam, result.residual, result.converged
    assert command.tension is not None
    known = W[n_a:, :n_a] @ command.tension
    result = solve_lcp(W[n_a:, n_a:], delta[n_a:] + known, start[n_a:])
    return np.concatenate([command.tension, result.lam]), result.residual, result.converged
