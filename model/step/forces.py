"""Constraint forces of a step: of actuators, of the contact basis and of unit columns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.contacts import ContactForces, Contacts
from tauten.model.numerics import Array, Bools, Ints, kernel
from tauten.model.step.contact_space import ContactSpace


@dataclass(frozen=True, slots=True)
class TangentialForces:
    """What friction does at unit columns.

    Attributes:
        force: (r, 3) forces across the normals, in the robot's frame [N].
        sliding: (r,) which contacts push and slide; those that push and do not slide stick.
        margin: (r,) distance to slip μ λ_n − |λ_t| of those that stick, 0 of others [N].
    """

    force: Array
    sliding: Bools
    margin: Array

    def copy(self) -> TangentialForces:
        """The same in arrays of its own."""
        return TangentialForces(self.force.copy(), self.sliding.copy(), self.margin.copy())

    def of(self, units: Bools) -> TangentialForces:
        """Those of some unit columns (r,)."""
        return TangentialForces(self.force[units], self.sliding[units], self.margin[units])


@dataclass(frozen=True, slots=True)
class Forces:
    """Constraint forces of a step.

    Attributes:
        effort: (n_a,) efforts of the actuators [N, Pa].
        beta: (k,) coefficients of the contact basis [N].
        extra: (r,) slots of the unit columns.
        extra_beta: (r,) forces of the unit columns [N].
        friction: of the unit columns; None where no contact in range has friction.
    """

    effort: Array
    beta: Array
    extra: Ints
    extra_beta: Array
    friction: TangentialForces | None = None

    @property
    def pushing(self) -> Ints:
        """Slots of the unit columns with a positive force."""
        return self.extra[self.extra_beta > 0.0]

    def of_same_contacts(self, other: Forces) -> bool:
        """Whether the same columns of the basis, and the same unit columns, push in both."""
        columns = np.array_equal(self.beta > 0.0, other.beta > 0.0)
        return columns and set(self.pushing.tolist()) == set(other.pushing.tolist())

    def on(self, found: Contacts, space: ContactSpace) -> ContactForces:
        """The contacts in range with their forces; columns of a space leave out those with friction."""
        normal = np.where(found.friction > 0.0, 0.0, space.lift(self.beta)[found.slots])
        _, own, at = np.intersect1d(found.slots, self.extra, return_indices=True)
        normal[own] += self.extra_beta[at]
        force, margin, sliding = normal[:, None] * found.normal, np.zeros_like(normal), normal > 0.0
        if self.friction is not None:
            force[own] += self.friction.force[at]
            margin[own], sliding[own] = self.friction.margin[at], self.friction.sliding[at]
        return ContactForces(found, force, sliding, margin)

    def at_candidates(self, space: ContactSpace, by_basis: Bools) -> Array:
        """Normal force of every candidate (n_c,) [N]; columns of a space push those `by_basis` (n_c,)."""
        lam = np.where(by_basis, space.lift(self.beta), 0.0)
        lam[self.extra] += self.extra_beta
        return lam

    def slides_otherwise(self, after: Forces) -> bool:
        """Whether contacts that push before and after have begun or ceased to slide, or slide backwards."""
        if self.friction is None or after.friction is None:
            return False
        one, other = self.friction, after.friction
        return _slide_otherwise(
            (self.extra, one.force, one.sliding), (after.extra, other.force, other.sliding)
        )

    def copy(self) -> Forces:
        """The same forces in arrays of their own."""
        friction = None if self.friction is None else self.friction.copy()
        return Forces(
            self.effort.copy(),
            self.beta.copy(),
            self.extra.copy(),
            self.extra_beta.copy(),
            friction,
        )


def no_forces(n_a: int, k: int) -> Forces:
    """Zero forces of n_a actuators and k columns of the contact basis."""
    return Forces(np.zeros(n_a), np.zeros(k), np.zeros(0, dtype=np.int64), np.zeros(0))


@kernel
def _slide_otherwise(before: tuple[Ints, Array, Bools], after: tuple[Ints, Array, Bools]) -> bool:
    """`Forces.slides_otherwise`; slots (r,), friction (r, 3), and which slide (r,)."""
    for i in range(len(before[0])):
        for j in range(len(after[0])):
            if before[0][i] == after[0][j]:
                along = np.dot(before[1][i], after[1][j])
                if before[2][i] != after[2][j] or (before[2][i] and along < 0.0):
                    return True
    return False
