"""Limits of the contact forces of whole pairs, as rows over the forces of a step.

Decisions keep the sum of the normal forces of a pair, of all pairs, and the distance to slip of a pair,

    μ Σ λ_n − |Σ λ_t| >= margin,

within what the robot file says. Least forces and distances to slip count from where a pair has pushed with
`GRASPED` of the least force until it pushes no more, or is let go: what something brushes is no grasp.
|Σ λ_t|, across the mean normal of the pair, is replaced by its largest component along `DIRECTIONS` over
cos(π / DIRECTIONS), at most 2 % more.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import compress

import numpy as np

from tauten.model.contact import ContactSet, ForceBounds
from tauten.model.contacts import ContactForces
from tauten.model.numerics import Array, Bools, Ints
from tauten.model.step.condensed_step import CondensedStep
from tauten.model.step.contact_space import ContactSpace
from tauten.model.step.enrichment import PredictedStep

REACHED = 1e-2  # of a limit, within which forces are at it
DIRECTIONS = 16  # of friction, in the plane of a pair
GRASPED = 0.1  # of the least force, from which it is kept
# Of a limit, by which the forces of a step may be beyond it: limits are those of plans.
TOLERATED = 0.05


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

    @property
    def names(self) -> tuple[str, str, str]:
        """What the least and the largest force and the least distance to slip are called."""
        smallest, largest = f"smallest force of {self.name}", f"largest force of {self.name}"
        return smallest, largest, f"smallest distance to slip of {self.name}"

    @property
    def least(self) -> float:
        """Sum of the normal forces without which its least limits cannot be kept [N]."""
        margin = self.bounds.margin / self.friction if self.bounds.margin > 0.0 else 0.0
        return max(self.bounds.least, margin)

    def among(self, pair: Ints) -> Bools:
        """Which contacts (k,) are of these pairs, by the numbers (k,) of theirs."""
        chosen: Bools = (pair[:, None] == self.pairs).any(axis=1)
        return chosen

    def sums(self, found: ContactForces) -> tuple[float, float]:
        """Sums of the normal forces of the pairs and of their friction [N]."""
        own = self.among(found.contacts.pair)
        normal, at = found.normal_force[own], found.contacts.normal[own]
        across = (found.force[own] - normal[:, None] * at).sum(axis=0)
        return float(normal.sum()), float(np.linalg.norm(across))


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

    def reached(self, forces: Array) -> bool:
        """Whether forces (n,) are at one of the limits or beyond it."""
        found = self.coefficients @ forces  # (p,)
        low, high = (1.0 + REACHED) * self.least, (1.0 - REACHED) * self.largest
        return bool(((found < low) | (found > high)).any())


@dataclass(frozen=True, slots=True)
class ForceLimits:
    """Limits of the contact forces of a robot.

    Attributes:
        limited: pairs that have limits.
        Psi: (n_c, k) columns of the basis of its contact forces.
    """

    limited: tuple[LimitedPairs, ...]
    Psi: Array

    def normal_sum(self, step: CondensedStep, limited: LimitedPairs) -> Array:
        """Sum of the normal forces of pairs, as a row over the contact forces of a step: (n,)."""
        contacts, modes = step.rows.contacts.found, step.reduced.modes
        chosen = limited.among(contacts.pair)
        by_basis = contacts.slots[chosen & (contacts.friction == 0.0)]
        row = np.zeros(len(step.compliance) - step.layout.contacts.start)
        row[: len(modes)] = self.Psi[by_basis][:, modes].sum(axis=0)
        row[step.gap_rows[len(modes) :] - step.layout.contacts.start] = chosen[step.extra]
        return row


@dataclass(frozen=True, slots=True)
class Grasp:
    """What a robot grasps: which least forces and distances to slip count beside its limits.

    Attributes:
        limits: of its contact forces.
        kept: which pairs have a grasp, whose least forces and distances to slip count.
        let_go: which are let go, until they push no more.
        released: names of the pairs that had a grasp when they were let go last.
    """

    limits: ForceLimits
    kept: tuple[bool, ...]
    let_go: tuple[bool, ...]
    released: tuple[str, ...] = ()

    @classmethod
    def at_start(cls, limits: ForceLimits) -> Grasp:
        """Where nothing has been grasped."""
        none = (False,) * len(limits.limited)
        return cls(limits, none, none)

    def among(self, pairs: Bools) -> Grasp | None:
        """The same with the limits of some pairs (q,) only; None where these have none."""
        own = [bool(pairs[one.pairs].all()) for one in self.limits.limited]
        if not any(own):
            return None
        limits = replace(self.limits, limited=tuple(compress(self.limits.limited, own)))
        return Grasp(limits, tuple(compress(self.kept, own)), tuple(compress(self.let_go, own)))

    def letting_go(self, found: ContactForces) -> Grasp:
        """Where all is let go that pushes in a step with these forces."""
        pushing = tuple(one.sums(found)[0] > 0.0 for one in self.limits.limited)
        return Grasp(self.limits, (False,) * len(pushing), pushing, self.kept_names)

    def after(self, found: ContactForces) -> Grasp:
        """After a step with these forces: what has been grasped, and what is let go still."""
        limited = self.limits.limited
        pushing = [one.sums(found)[0] for one in limited]
        let_go = tuple(
            gone and force > 0.0 for gone, force in zip(self.let_go, pushing, strict=True)
        )
        kept = tuple(
            force > 0.0 and not gone and (before or force >= GRASPED * one.least)
            for one, force, gone, before in zip(limited, pushing, let_go, self.kept, strict=True)
        )
        if (kept, let_go) == (self.kept, self.let_go):
            return self
        return replace(self, kept=kept, let_go=let_go)

    @property
    def kept_names(self) -> tuple[str, ...]:
        """The names of the pairs that have a grasp, whose least forces and distances to slip count."""
        pairs = zip(self.limits.limited, self.kept, strict=True)
        return tuple(one.name for one, kept in pairs if kept and one.least > 0.0)

    def exceeded(self, found: ContactForces) -> tuple[str, ...]:
        """The names of the limits that the forces of a step are beyond."""
        names = list[str]()
        for one, kept in zip(self.limits.limited, self.kept, strict=True):
            (normal, friction), bounds = one.sums(found), one.bounds
            smallest, largest, margin = one.names
            if kept and normal < (1.0 - TOLERATED) * bounds.least:
                names.append(smallest)
            if normal > (1.0 + TOLERATED) * bounds.largest:
                names.append(largest)
            apart = one.friction * normal - friction
            if kept and bounds.margin > 0.0 and apart < (1.0 - TOLERATED) * bounds.margin:
                names.append(margin)
        return tuple(names)

    def rows(self, step: CondensedStep, held: PredictedStep) -> ForceRows | None:
        """The limits as rows over the contact forces of a step; None where none can push.

        Forces are in units of the compliance of the contacts, so that rows are comparable with positions. The
        step leads to `held` when the actuators hold.
        """
        found, rows = [], []
        W = np.diag(step.compliance.W)[step.gap_rows]
        scale = float(W.mean()) if len(W) > 0 else 0.0
        if not scale > 0.0:
            return None
        before = held.lam[held.step.layout.contacts]
        for one, kept in zip(self.limits.limited, self.kept, strict=True):
            normal = self.limits.normal_sum(step, one)
            if not normal.any():
                continue
            keeps = kept and self.limits.normal_sum(held.step, one) @ before > 0.0
            bounds, (smallest, largest, name) = one.bounds, one.names
            least = bounds.least if keeps and bounds.least > 0.0 else -np.inf
            if np.isfinite([least, bounds.largest]).any():
                rows.append(normal)
                found.append((least, bounds.largest, (smallest, largest)))
            if keeps and bounds.margin > 0.0:
                for row in one.friction * normal - friction_sums(step, one):
                    rows.append(row)
                    found.append((bounds.margin, np.inf, (name, name)))
        if not rows:
            return None
        lower, upper, named = zip(*found, strict=True)
        return ForceRows(
            scale * np.array(rows), scale * np.array(lower), scale * np.array(upper), named
        )


def friction_sums(step: CondensedStep, limited: LimitedPairs) -> Array:
    """Sum of the friction of pairs along some directions, over cos(π / DIRECTIONS): (DIRECTIONS, n)."""
    contacts = step.rows.contacts.found
    rows = np.zeros((DIRECTIONS, len(step.compliance) - step.layout.contacts.start))
    own = np.flatnonzero(limited.among(contacts.pair[step.extra]))
    if len(own) == 0 or not step.frictional:
        return rows
    touching = contacts.at(step.extra[own])
    mean = touching.normal.sum(axis=0)
    across = np.linalg.svd(mean[None])[2][1:]  # (2, 3) across the mean normal
    angle = 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    along = np.stack([np.cos(angle), np.sin(angle)], axis=1) @ across  # (DIRECTIONS, 3)
    parts = np.einsum("rti,ki->krt", touching.axes()[:, 1:], along) / np.cos(np.pi / DIRECTIONS)
    first = step.gap_rows[len(step.reduced) + own] - step.layout.contacts.start
    for tangent in range(2):
        rows[:, first + 1 + tangent] = parts[:, :, tangent]
    return rows


def force_limits(contacts: ContactSet, space: ContactSpace) -> ForceLimits | None:
    """Limits of the contact forces of a robot, which are of a space; None where it has none."""
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
