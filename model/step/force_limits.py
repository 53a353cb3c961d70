"""Limits of the contact forces of whole pairs, as rows over the forces of a step.

Decisions keep the sum of the normal forces of a pair, of all pairs, and the distance to slip of a pair,

    μ Σ λ_n − |Σ λ_t| >= margin,

within what the robot file says. Least forces and distances to slip count where a pair pushes when the
actuators hold: a pair that touches nothing has no grasp to keep. |Σ λ_t|, across the mean normal of the pair,
is replaced by its largest component along `DIRECTIONS` over cos(π / DIRECTIONS), at most 2 % more.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.contact import ContactSet, ForceBounds
from tauten.model.numerics import Array, Ints
from tauten.model.step.condensed_step import CondensedStep
from tauten.model.step.contact_space import ContactSpace
from tauten.model.step.enrichment import PredictedStep

DIRECTIONS = 16  # of friction, in the plane of a pair


@dataclass(frozen=True, slots=True)
class LimitedPairs:
    """Pairs whose forces have limits together.

    Attributes:
        name: in messages.
        pairs: (p,) their numbers.
        friction: coefficient, where they are one.
        bounds: of their forces.
    """

    name: str
    pairs: Ints
    friction: float
    bounds: ForceBounds


@dataclass(frozen=True, slots=True)
class ForceRows:
    """Rows over the forces of the contacts of a step, which are to stay within limits.

    Attributes:
        coefficients: (p, n) of the reduced contacts and the rows of unit columns [m/N].
        least: (p,) of each row [m].
        largest: (p,) of each row [m].
        names: of the lower and the upper limit of each row.
    """

    coefficients: Array
    least: Array
    largest: Array
    names: tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True)
class ForceLimits:
    """Limits of the contact forces of a robot.

    Attributes:
        limited: pairs that have limits.
        Psi: (n_c, k) columns of the basis of its contact forces.
    """

    limited: tuple[LimitedPairs, ...]
    Psi: Array

    def rows(self, step: CondensedStep, held: PredictedStep) -> ForceRows | None:
        """The limits as rows over the contact forces of a step; None where none can push.

        Forces are in units of the compliance of the contacts, so that rows are comparable with positions.

        Args:
            step: whose forces are decided.
            held: where the same step leads when the actuators hold.
        """
        found, rows = [], []
        W = np.diag(step.compliance.W)[step.gap_rows]
        scale = float(W.mean()) if len(W) > 0 else 0.0
        if not scale > 0.0:
            return None
        before = held.lam[held.step.layout.contacts]
        for one in self.limited:
            normal = self.normal_sum(step, one)
            if not normal.any():
                continue
            pushes, bounds = self.normal_sum(held.step, one) @ before > 0.0, one.bounds
            least = bounds.least if pushes and bounds.least > 0.0 else -np.inf
            if np.isfinite([least, bounds.largest]).any():
                names = f"smallest force of {one.name}", f"largest force of {one.name}"
                rows.append(normal)
                found.append((least, bounds.largest, names))
            if pushes and bounds.margin > 0.0:
                name = f"smallest distance to slip of {one.name}"
                for row in one.friction * normal - friction_sums(step, one):
                    rows.append(row)
                    found.append((bounds.margin, np.inf, (name, name)))
        if not rows:
            return None
        lower, upper, named = zip(*found, strict=True)
        return ForceRows(
            scale * np.array(rows), scale * np.array(lower), scale * np.array(upper), named
        )

    def normal_sum(self, step: CondensedStep, limited: LimitedPairs) -> Array:
        """Sum of the normal forces of pairs, as a row over the contact forces of a step: (n,).

        Args:
            step: the step.
            limited: the pairs.
        """
        contacts, modes = step.rows.contacts.found, step.reduced.modes
        chosen = np.isin(contacts.pair, limited.pairs)
        by_basis = contacts.slots[chosen & (contacts.friction == 0.0)]
        row = np.zeros(len(step.compliance) - step.layout.contacts.start)
        row[: len(modes)] = self.Psi[by_basis][:, modes].sum(axis=0)
        row[step.gap_rows[len(modes) :] - step.layout.contacts.start] = chosen[step.extra]
        return row


def friction_sums(step: CondensedStep, limited: LimitedPairs) -> Array:
    """Sum of the friction of pairs along some directions, over cos(π / DIRECTIONS): (DIRECTIONS, n).

    Args:
        step: with friction; rows are over its contact forces.
        limited: the pairs.
    """
    contacts = step.rows.contacts.found
    rows = np.zeros((DIRECTIONS, len(step.compliance) - step.layout.contacts.start))
    own = np.flatnonzero(np.isin(contacts.pair[step.extra], limited.pairs))
    if len(own) == 0 or not step.frictional:
        return rows
    touching = contacts.at(step.extra[own])
    mean = touching.normal.sum(axis=0)
    across = np.linalg.svd(mean[None])[2][1:]  # (2, 3) across the mean normal
    angle = 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    along = np.stack([np.cos(angle), np.sin(angle)], axis=1) @ across  # (DIRECTIONS, 3)
    parts = np.einsum("rti,ki->krt", touching.tangents(), along) / np.cos(np.pi / DIRECTIONS)
    first = step.gap_rows[len(step.reduced) + own] - step.layout.contacts.start
    for tangent in range(2):
        rows[:, first + 1 + tangent] = parts[:, :, tangent]
    return rows


def force_limits(contacts: ContactSet, space: ContactSpace) -> ForceLimits | None:
    """Limits of the contact forces of a robot; None where it has none.

    Args:
        contacts: of the robot.
        space: basis of its contact forces.
    """
    limited = [
        LimitedPairs(pair.name, np.array([number]), pair.friction, pair.bounds)
        for number, pair in enumerate(contacts.pairs)
        if pair.bounds.given
    ]
    limited += [
        LimitedPairs(one.name, np.array(one.pairs), 0.0, ForceBounds(largest=one.force))
        for one in contacts.sums
    ]
    if not limited:
        return None
    columns = [space.lift(one) for one in np.eye(space.k)]
    Psi = np.array(columns).T if columns else np.zeros((contacts.n_slots, 0))
    return ForceLimits(tuple(limited), Psi)
