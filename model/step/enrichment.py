"""Enrichment: unit columns join the contact basis where it leaves candidates too deep.

After every solve the gaps of all candidates in range are predicted. Where one is deeper than the
tolerance, the unit column of that candidate joins the basis for this step, and the step is solved again.
With an empty basis and a tight tolerance the same loop solves full pointwise contact and never forms the
columns of candidates that do not push.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from tauten.model.arguments import of_kind
from tauten.model.contact import ContactSet
from tauten.model.contacts import ContactForces
from tauten.model.numerics import Array, Ints
from tauten.model.rows import ContactRows
from tauten.model.step.condensed_step import CondensedStep
from tauten.model.step.contact_space import ContactSpace, EmptySpace


@dataclass(frozen=True, slots=True)
class Enrichment:
    """When and how unit columns join the contact basis.

    Attributes:
        tolerance: predicted penetration that is accepted [m].
        rounds: how often columns may be added in one step; 0 switches enrichment off.
        per_pair: columns a round may add for each contact pair.
    """

    tolerance: float
    rounds: int
    per_pair: int


def default_enrichment(tolerance: float) -> Enrichment:
    """Enrichment to a tolerance [m]: per round the deepest candidate of each pair, at most three rounds."""
    return Enrichment(tolerance, rounds=3, per_pair=1)


# Pointwise contact: columns are added until no candidate is deeper than this [m].
POINTWISE = Enrichment(tolerance=1e-8, rounds=60, per_pair=8)
WITH_FRICTION = Enrichment(tolerance=1e-8, rounds=200, per_pair=2)  # few, of three rows each
NO_ENRICHMENT = Enrichment(tolerance=np.inf, rounds=0, per_pair=0)


def contact_model(
    contact: Literal["none", "full"] | ContactSpace,
    candidates: ContactSet,
    reduced: Enrichment,
    given: Enrichment | None = None,
) -> tuple[ContactSpace, Enrichment]:
    """Basis and enrichment of "none", "full" or a basis of contact forces.

    Pairs with friction are carried by unit columns, as many as it takes, also beside a basis.

    Args:
        contact: "none"; "full", pointwise; or a basis of contact forces.
        candidates: of the robot.
        reduced: enrichment of a basis.
        given: instead of the enrichment that follows from these; None: that one.

    Raises:
        TypeError: the enrichment is none.
        ValueError: `contact` is none of these, or a basis with another number of slots.
    """
    n_c = candidates.n_slots
    chosen = None if given is None else of_kind("enrichment", given, Enrichment)
    if isinstance(contact, str) and contact == "none":
        return EmptySpace(n_c), chosen or NO_ENRICHMENT
    if isinstance(contact, str) and contact == "full":
        pointwise = WITH_FRICTION if candidates.frictional else POINTWISE
        return EmptySpace(n_c), chosen or pointwise
    if not isinstance(contact, ContactSpace):
        raise ValueError(f'contact is {contact!r:.80}, allowed are "none", "full" or a basis')
    slots = len(contact.lift(np.zeros(contact.k)))
    if slots != n_c:
        raise ValueError(f"the contact basis has {slots} slots, the robot {n_c} candidates")
    return contact, chosen or (WITH_FRICTION if candidates.frictional else reduced)


@dataclass(frozen=True, slots=True)
class PredictedStep:
    """A step with its forces, and their predicted effect.

    Attributes:
        step: with the unit columns that joined.
        lam: (m,) forces on all rows of `step.compliance`, zero on the effectors [N].
        delta: (m,) predicted row values δ_free + W λ [m].
        effort: (n_a,) of the actuators, which is not λ where the tangent is augmented, see
            `CondensedStep.efforts` [N, Pa].
        dv: (n,) velocity change [m/s].
        deepest_gap: smallest predicted gap of the candidates in range [m], +inf without any.
        within_tolerance: whether no candidate without a unit column is deeper than the tolerance.
        residual: complementarity of the forces of a forward step [m].
        converged: whether that met its tolerance, and the positions of bilateral actuators theirs.
    """

    step: CondensedStep
    lam: Array
    delta: Array
    effort: Array
    dv: Array
    deepest_gap: float
    within_tolerance: bool
    residual: float = 0.0
    converged: bool = True

    def touching(self, space: ContactSpace) -> ContactForces:
        """The contacts in range with their forces, of a basis of contact forces."""
        forces = self.step.split(self.lam, space.k)
        return forces.on(self.step.rows.contacts.found, space)

    @property
    def contacts_push(self) -> bool:
        """Whether any contact has a force."""
        return bool((self.lam[self.step.layout.contacts] > 0.0).any())


def predict(
    step: CondensedStep,
    enrichment: Enrichment,
    lam: Array,
    more: bool,
    residual: float = 0.0,
    converged: bool = True,
) -> PredictedStep | CondensedStep:
    """The effect of forces, or where they leave candidates too deep the step with more unit columns.

    The caller solves in a loop, as `tauten.model.step.forward_step.forward_step` does.

    Args:
        step: what was solved.
        enrichment: tolerance and number of columns.
        lam: (m,) forces on the rows of `step.compliance` [N].
        more: whether columns may be added, because rounds are left and the solver succeeded.
        residual: complementarity of these forces [m].
        converged: whether they met the tolerance.
    """
    compliance, system, contacts = step.compliance, step.system, step.rows.contacts
    dv = system.v_free - system.v + system.h * compliance.pushed(lam)
    gaps = contacts.rows.after(system.h, system.v + dv)
    deepest, worst = float(np.minimum.reduce(gaps, initial=np.inf)), step.extra[:0]
    if deepest < -enrichment.tolerance:  # hardly ever
        worst = worst_rows(contacts, gaps, enrichment, step.extra)
    if len(worst) > 0 and more:
        return step.with_unit_columns(worst)
    delta = compliance.delta_free + compliance.W @ lam
    effort = lam[step.layout.actuators] if step.rho is None else step.efforts(lam, delta)
    within = len(worst) == 0
    return PredictedStep(step, lam, delta, effort, dv, deepest, within, residual, converged)


def worst_rows(contacts: ContactRows, gaps: Array, enrichment: Enrichment, known: Ints) -> Ints:
    """Rows that violate the tolerance most, up to `per_pair` of each pair: (r,).

    Args:
        contacts: candidates in range.
        gaps: (m,) their predicted gaps [m].
        enrichment: tolerance and number of columns.
        known: rows that have a unit column already.
    """
    new = gaps < -enrichment.tolerance
    new[known] = False
    bad = np.flatnonzero(new)
    order = bad[np.argsort(gaps[bad], kind="stable")]
    pair = contacts.pair[order]
    rank = np.zeros(len(order), dtype=np.int64)  # position among the bad rows of the same pair
    for p in np.unique(pair):
        rank[pair == p] = np.arange(int((pair == p).sum()))
    return np.sort(order[rank < enrichment.per_pair])
