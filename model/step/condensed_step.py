"""One step, condensed: the linear system, the rows, and the compliance between them.

Effectors (where they are needed), actuators, reduced contacts and unit columns, in this order, form the rows
of one `Compliance`. The unknowns are the forces on them: from a target by the controller, from
efforts or positions of the actuators by the simulator. The rows of actuators with a spring are in the
coordinate of the motor before the spring.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tauten.model.layout import Layout
from tauten.model.numerics import Array, Bools, Ints
from tauten.model.robot import Robot
from tauten.model.rows import ContactRows
from tauten.model.signals import Laws
from tauten.model.state import RobotRows, State
from tauten.model.step.compliance import Compliance, extended, row_compliance
from tauten.model.step.contact_space import ContactSpace, ReducedContacts
from tauten.model.system import Integration, System


@dataclass(frozen=True, slots=True)
class Forces:
    """Constraint forces of a step.

    Attributes:
        effort: (n_a,) efforts of the actuators [N, Pa].
        beta: (k,) coefficients of the contact basis [N].
        extra: (r,) slots of the unit columns.
        extra_beta: (r,) forces of the unit columns [N].
    """

    effort: Array
    beta: Array
    extra: Ints
    extra_beta: Array

    @property
    def pushing(self) -> Ints:
        """Slots of the unit columns with a positive force."""
        return self.extra[self.extra_beta > 0.0]

    def at_candidates(self, space: ContactSpace) -> Array:
        """Force of every contact candidate: (n_c,) [N].

        Args:
            space: whose columns `beta` has.
        """
        lam = space.lift(self.beta).copy()
        lam[self.extra] += self.extra_beta
        return lam

    def copy(self) -> Forces:
        """The same forces in arrays of their own."""
        return Forces(
            self.effort.copy(), self.beta.copy(), self.extra.copy(), self.extra_beta.copy()
        )


def no_forces(n_a: int, k: int) -> Forces:
    """Zero forces of n_a actuators and k columns of the contact basis."""
    return Forces(np.zeros(n_a), np.zeros(k), np.zeros(0, dtype=np.int64), np.zeros(0))


@dataclass(frozen=True, slots=True)
class CondensedStep:
    """All of a step but the forces.

    Attributes:
        state: where the step starts.
        system: factorised A, v_free.
        rows: effectors, actuators, contacts in range.
        reduced: contact rows of the basis.
        extra: (r,) rows of `rows.contacts` that have a unit column.
        compliance: of effectors (all or none), actuators, reduced contacts, unit columns, in this order.
        layout: where they are in it.
        laws: of the actuators.
    """

    state: State
    system: System
    rows: RobotRows
    reduced: ReducedContacts
    extra: Ints
    compliance: Compliance
    layout: Layout
    laws: Laws

    @property
    def n_contacts(self) -> int:
        """Contact rows in `compliance`: reduced contacts and unit columns."""
        return len(self.reduced) + len(self.extra)

    def with_unit_columns(self, chosen: Ints) -> CondensedStep:
        """The step with unit columns for more rows (r,) of `rows.contacts`."""
        added = unit_rows(self.rows.contacts, chosen)
        return replace(
            self,
            extra=np.concatenate([self.extra, chosen]),
            compliance=extended(self.system, self.compliance, *added),
        )

    def pushing(self, forces: Forces) -> Bools:
        """Which contact rows had a positive force in `forces`: (n_contacts,) bool."""
        reduced = forces.beta[self.reduced.modes] > 0.0
        if len(self.extra) == 0:
            return reduced
        slots = self.rows.contacts.slots[self.extra]
        kept = (slots[:, None] == forces.pushing).any(axis=1)  # few: faster than np.isin
        return np.concatenate([reduced, kept])

    def split(self, lam: Array, k: int) -> Forces:
        """Forces lam (m,) by actuator, column of a basis with k columns, and slot."""
        contacts, beta = lam[self.layout.contacts], np.zeros(k)
        beta[self.reduced.modes] = contacts[: len(self.reduced)]
        slots = self.rows.contacts.slots[self.extra] if len(self.extra) > 0 else self.extra
        return Forces(lam[self.layout.actuators], beta, slots, contacts[len(self.reduced) :])


def condense_step(
    robot: Robot,
    space: ContactSpace,
    state: State,
    forces: Forces,
    contacts: bool,
    effectors: bool,
    integration: Integration | None = None,
) -> CondensedStep:
    """Linearise, detect contacts, reduce them and condense: all of a step that needs no target.

    Args:
        robot: its factorisation workspace is in use until the next call.
        space: basis of the contact forces.
        state: where the step starts.
        forces: of the last step. Its tensions add to the tangent; unit columns that pushed are kept.
        contacts: whether to detect contacts.
        effectors: whether the compliance has rows of the effectors.
        integration: another scheme than the robot's own.

    Raises:
        FactorisationError: the state has diverged.
    """
    system = robot.linearise(state, forces.effort, integration)
    return condensed(robot, space, state, forces, system, contacts, effectors)


def condensed(
    robot: Robot,
    space: ContactSpace,
    state: State,
    forces: Forces,
    system: System,
    contacts: bool,
    effectors: bool,
) -> CondensedStep:
    """Condense a system that has been factorised.

    Args:
        robot: whose workspace contains the factors.
        space: basis of the contact forces.
        state: where the system was linearised.
        forces: unit columns that pushed are kept.
        system: the system.
        contacts: whether to detect contacts.
        effectors: whether the compliance has rows of the effectors.
    """
    rows = robot.rows(state, contacts=contacts)
    reduced = space.reduce(rows.contacts)
    extra = rows.contacts.rows_of(forces.pushing)
    H = [rows.actuators.dense(), reduced.H]
    if effectors:
        H.insert(0, rows.effectors.dense())
    if len(extra) > 0:
        H.append(unit_rows(rows.contacts, extra)[0])
    layout = robot.layout if effectors else robot.layout.without_effectors()
    compliance = _through(robot, system, np.concatenate(H), rows, reduced, extra, layout)
    return CondensedStep(
        state, system, rows, reduced, extra, compliance, layout, robot.actuators.laws
    )


def recondensed(robot: Robot, step: CondensedStep, system: System) -> CondensedStep:
    """The same rows at the same state, condensed through another system.

    Args:
        robot: of the step.
        step: its rows and contacts are kept.
        system: another scheme's, linearised at the same state.
    """
    H, kept = step.compliance.H, (step.rows, step.reduced, step.extra, step.layout)
    return replace(step, system=system, compliance=_through(robot, system, H, *kept))


def _through(
    robot: Robot,
    system: System,
    H: Array,
    rows: RobotRows,
    reduced: ReducedContacts,
    extra: Ints,
    layout: Layout,
) -> Compliance:
    """Compliance of rows H (m, n) through a system, those of sprung actuators at the motor."""
    delta = [rows.effectors.delta] * (layout.n_e > 0) + [rows.actuators.delta, reduced.delta]
    if len(extra) > 0:
        delta.append(rows.contacts.rows.delta[extra])
    compliance = row_compliance(system, H, np.concatenate(delta))
    springs = robot.actuators.laws.springs
    if springs is not None:
        between = compliance.W[layout.actuators, layout.actuators]
        between[np.diag_indices(layout.n_a)] += springs.flexibility
        compliance.delta_free[layout.actuators] += springs.shift
    return compliance


def unit_rows(contacts: ContactRows, chosen: Ints) -> tuple[Array, Array]:
    """Dense H (r, n) and gaps (r,) [m] of single candidates."""
    return contacts.rows.chosen(chosen), contacts.rows.delta[chosen]
