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
from tauten.model.numerics import Array, Bools, Ints, kernel
from tauten.model.robot import Robot
from tauten.model.rows import ContactRows
from tauten.model.signals import Laws
from tauten.model.state import RobotRows, State
from tauten.model.step.compliance import Compliance, extended, row_compliance
from tauten.model.step.contact_space import ContactSpace, ReducedContacts
from tauten.model.step.forces import Forces, TangentialForces
from tauten.model.system import Integration, System

NO_FRICTION = np.zeros(0)
STILL = 1e-7  # of the largest displacement without contact, slip that counts as none


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
        frictional: whether a contact in range has friction; unit columns then have three rows each.
        slid: (n,) displacement since the start of the step that the system has not, where it was not
            linearised there [m]; None: none. It counts for slip.
        rho: (n_a,) stiffness ρ along actuators that is added to the tangent, see `efforts`; None: none.
    """

    state: State
    system: System
    rows: RobotRows
    reduced: ReducedContacts
    extra: Ints
    compliance: Compliance
    layout: Layout
    laws: Laws
    frictional: bool
    slid: Array | None = None
    rho: Array | None = None

    def efforts(self, lam: Array, delta: Array) -> Array:
        """Efforts (n_a,) of the actuators in a solved step with stiffness along actuators.

        Where a stiffness ρ along an actuator is added to the tangent, the unknown force of its row is
        λ + ρ (δ_a − δ_a,0), with δ_a,0 at the start of the step: the motion is that of the effort λ.

        Args:
            lam: (m,) forces on all rows.
            delta: (m,) values of the rows.
        """
        assert self.rho is not None
        actuators = self.layout.actuators
        effort: Array = lam[actuators] - self.rho * (delta[actuators] - self.rows.actuators.delta)
        return effort

    @property
    def gap_rows(self) -> Ints:
        """Rows of `compliance` that are gaps: of reduced contacts, and the first one of each unit column."""
        first, end = self.layout.n_e + self.layout.n_a, len(self.compliance)
        units = np.arange(first + len(self.reduced), end, 3 if self.frictional else 1)
        return np.concatenate([np.arange(first, first + len(self.reduced)), units])

    @property
    def friction(self) -> Array:
        """Coefficients of friction of the unit columns (r,); none where no contact in range has friction."""
        return self.rows.contacts.found.friction[self.extra] if self.frictional else NO_FRICTION

    @property
    def n_contacts(self) -> int:
        """Reduced contacts and unit columns."""
        return len(self.reduced) + len(self.extra)

    def with_unit_columns(self, chosen: Ints) -> CondensedStep:
        """The step with unit columns for more rows (r,) of `rows.contacts`."""
        added = unit_rows(self.rows.contacts, chosen, self.system.h, self.slid)
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
        contacts, beta, modes = lam[self.layout.contacts], np.zeros(k), self.reduced.modes
        beta[modes] = contacts[: len(modes)]
        slots = self.rows.contacts.slots[self.extra] if len(self.extra) > 0 else self.extra
        units = contacts[len(modes) :]
        if not self.frictional:
            return Forces(lam[self.layout.actuators], beta, slots, units)
        first = self.layout.n_e + self.layout.n_a + len(modes)
        W, q = self.compliance.W, self.compliance.delta_free
        tangents = self.rows.contacts.found.tangents(self.extra)
        normal, force, sliding, margin = _coulomb(W, q, lam, first, self.friction, tangents)
        friction = TangentialForces(force, sliding, margin)
        return Forces(lam[self.layout.actuators], beta, slots, normal, friction)


@kernel
def _coulomb(
    W: Array, q: Array, lam: Array, first: int, mu: Array, tangents: Array
) -> tuple[Array, Array, Bools, Array]:
    """Normal forces (r,) of the unit columns, and the arrays of their `TangentialForces`.

    Of slip and distance to slip the smaller one is rounding.

    Args:
        W: (m, m) compliance [m/N].
        q: (m,) row values without forces [m].
        lam: (m,) forces on all rows [N].
        first: row of the first unit column.
        mu: (r,) coefficients of friction.
        tangents: (r, 2, 3) directions of the rows.
    """
    r = len(mu)
    normal, force, margin = np.empty(r), np.zeros((r, 3)), np.zeros(r)
    sliding, largest = np.zeros(r, np.bool_), 0.0
    for row in range(first, len(q)):
        largest = max(largest, abs(q[row]))
    for k in range(r):
        at = first + 3 * k
        normal[k], slip, across, unit = lam[at], 0.0, 0.0, W[at, at]
        for t in range(1, 3):
            moved = q[at + t]
            for row in range(len(lam)):
                moved += W[at + t, row] * lam[row]
            slip, across = slip + moved * moved, across + lam[at + t] * lam[at + t]
            unit = max(unit, W[at + t, at + t])
            for i in range(3):
                force[k, i] += lam[at + t] * tangents[k, t - 1, i]
        slip, reserve = np.sqrt(slip), mu[k] * normal[k] - np.sqrt(across)
        if normal[k] > 0.0:
            sliding[k] = slip > STILL * largest and slip > unit * reserve
            margin[k] = 0.0 if sliding[k] else reserve
    return normal, force, sliding, margin


def condense_step(
    robot: Robot,
    space: ContactSpace,
    state: State,
    forces: Forces,
    contacts: bool,
    effectors: bool,
    integration: Integration | None = None,
    slid: Array | None = None,
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
        slid: (n,) see `CondensedStep`.

    Raises:
        FactorisationError: the state has diverged.
    """
    system = robot.linearise(state, forces.effort, integration)
    return condensed(robot, space, state, forces, system, contacts, effectors, slid)


def condensed(
    robot: Robot,
    space: ContactSpace,
    state: State,
    forces: Forces,
    system: System,
    contacts: bool,
    effectors: bool,
    slid: Array | None = None,
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
        slid: (n,) see `CondensedStep`.
    """
    rows = robot.rows(state, contacts, effectors)
    reduced, extra = space.reduce(rows.contacts), forces.extra
    if len(extra) > 0:
        extra = rows.contacts.rows_of(forces.pushing)
    H, delta = [rows.actuators.dense(), reduced.H], [rows.actuators.delta, reduced.delta]
    if effectors:
        H.insert(0, rows.effectors.dense())
        delta.insert(0, rows.effectors.delta)
    if len(extra) > 0:
        units = unit_rows(rows.contacts, extra, system.h, slid)
        H.append(units[0])
        delta.append(units[1])
    layout = robot.layout if effectors else robot.layout.without_effectors()
    frictional = rows.contacts.tangents is not None
    compliance = row_compliance(system, np.concatenate(H), np.concatenate(delta), frictional)
    if robot.actuators.laws.springs is not None:
        compliance.spring(robot.actuators.laws.springs, layout.actuators)
    return CondensedStep(
        state, system, rows, reduced, extra, compliance, layout, robot.actuators.laws,
        frictional, slid,
    )  # fmt: skip


def recondensed(
    space: ContactSpace,
    step: CondensedStep,
    system: System,
    ahead: float = 0.0,
    rho: Array | None = None,
) -> CondensedStep:
    """The same rows at the same state, condensed through another system.

    Obstacles that move have made the same share of their way. Slip counts all of it.

    Args:
        space: basis of the contact forces.
        step: its rows and contacts are kept; obstacles that move are where they are after the new step.
        system: another scheme's, linearised at the same state.
        ahead: of that scheme.
        rho: (n_a,) stiffness along actuators in the tangent of the system; None: none.
    """
    rows, reduced, n_e = step.rows, step.reduced, step.layout.n_e
    later = (1.0 - ahead) * system.h - step.system.h  # s
    slid = None if ahead == 0.0 else ahead * system.h * step.state.v
    if rows.contacts.found.surface is not None:
        rows = replace(rows, contacts=rows.contacts.later(later))
        reduced = space.reduce(rows.contacts)
    delta = [rows.effectors.delta[:n_e], rows.actuators.delta, reduced.delta]
    if len(step.extra) > 0:
        delta.append(unit_rows(rows.contacts, step.extra, system.h, slid)[1])
    H, delta_free = step.compliance.H, np.concatenate(delta)
    compliance = row_compliance(system, H, delta_free, step.frictional)
    if step.laws.springs is not None:
        compliance.spring(step.laws.springs, step.layout.actuators)
    return CondensedStep(
        step.state, system, rows, reduced, step.extra, compliance, step.layout, step.laws,
        step.frictional, slid, rho,
    )  # fmt: skip


def unit_rows(
    contacts: ContactRows, chosen: Ints, h: float, slid: Array | None = None
) -> tuple[Array, Array]:
    """Dense H and values [m] of single candidates: gaps (r,), and with friction slip too (3 r,).

    Args:
        contacts: candidates in range.
        chosen: (r,) some of them.
        h: time step [s].
        slid: (n,) displacement since the start of the step [m]; None: none.
    """
    normal = contacts.rows.chosen(chosen)
    if contacts.tangents is None:
        return normal, contacts.rows.delta[chosen]
    across, n = contacts.tangents.chosen(chosen), normal.shape[1]
    H = np.concatenate([normal[:, None], across.reshape(-1, 2, n)], axis=1).reshape(-1, n)
    delta = unit_values(contacts, chosen, h)
    if slid is not None:
        delta.reshape(-1, 3)[:, 1:] += (across @ slid).reshape(-1, 2)
    return H, delta


def unit_values(contacts: ContactRows, chosen: Ints, h: float) -> Array:
    """Gaps (r,) of single candidates, and with friction their slip without motion of the robot (3 r,) [m].

    Args:
        contacts: candidates in range.
        chosen: (r,) some of them.
        h: time step, in which obstacles move [s].
    """
    gaps, found = contacts.rows.delta[chosen], contacts.found
    if contacts.tangents is None:
        return gaps
    slip = np.zeros((len(chosen), 2))
    if found.surface is not None:
        slip -= h * np.einsum("rti,ri->rt", found.tangents(chosen), found.surface[chosen])
    return np.concatenate([gaps[:, None], slip], axis=1).ravel()
