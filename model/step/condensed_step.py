"""One step, condensed: the linear system, the rows, and the compliance between them.

Effectors (where they are needed), actuators, reduced contacts and unit columns, in this order, form the rows
of one `Compliance`. The unknowns are the forces on them: from a target by the controller, from
efforts or positions of the actuators by the simulator. The rows of actuators with a spring are in the
coordinate of the motor before the spring.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tauten.model.layout import Layout, row_layout
from tauten.model.numerics import Array, Bools, Ints, kernel
from tauten.model.robot import Robot
from tauten.model.rows import ContactRows
from tauten.model.signals import Laws
from tauten.model.state import RobotRows, State
from tauten.model.step.compliance import Compliance, extended, row_compliance
from tauten.model.step.contact_space import ContactSpace, EmptySpace, ReducedContacts
from tauten.model.step.forces import Forces, TangentialForces
from tauten.model.system import Integration, System

NO_FRICTION = np.zeros(0)
NO_AXES = np.zeros((0, 3, 3))
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
        axes: (r, 3, 3) of these, see `Contacts.axes`; none where no contact in range has friction.
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
    axes: Array
    compliance: Compliance
    layout: Layout
    laws: Laws
    frictional: bool
    slid: Array | None = None
    rho: Array | None = None

    def efforts(self, lam: Array, delta: Array) -> Array:
        """Efforts (n_a,) of the actuators in a step with stiffness along actuators, of lam and delta (m,).

        Where a stiffness ρ along an actuator is added to the tangent, the unknown force of its row is λ + ρ
        (δ_a − δ_a,0), with δ_a,0 at the start of the step: the motion is that of the effort λ.
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
        H, delta, axes = unit_rows(self.rows.contacts, chosen, self.system.h, self.slid)
        return replace(
            self,
            extra=np.concatenate([self.extra, chosen]),
            axes=np.concatenate([self.axes, axes]),
            compliance=extended(self.system, self.compliance, H, delta),
        )

    def without_contacts(self) -> CondensedStep:
        """The step as if no contact were in range."""
        known, first, found = self.compliance, self.layout.contacts.start, self.rows.contacts.found
        none = ContactRows.out_of_range(known.H[:0], found.n_slots, self.rows.contacts.frictional)
        return replace(
            self,
            rows=replace(self.rows, contacts=none),
            reduced=EmptySpace(found.n_slots).reduce(none),
            extra=none.slots,
            axes=NO_AXES,
            compliance=Compliance(
                known.H[:first],
                known.Y[:first],
                known.W[:first, :first],
                known.delta_free[:first],
                known.halves,
            ),
            frictional=False,
        )

    def split(self, lam: Array, k: int) -> Forces:
        """Forces lam (m,) by actuator, column of a basis with k columns, and slot."""
        contacts, beta, modes = lam[self.layout.contacts], np.zeros(k), self.reduced.modes
        effort = lam[self.layout.actuators]
        if self.rho is not None:
            effort = self.efforts(lam, self.compliance.delta_free + self.compliance.W @ lam)
        beta[modes] = contacts[: len(modes)]
        slots = self.rows.contacts.slots[self.extra] if len(self.extra) > 0 else self.extra
        units = contacts[len(modes) :]
        if not self.frictional:
            return Forces(effort, beta, slots, units)
        first = self.layout.n_e + self.layout.n_a + len(modes)
        W, q = self.compliance.W, self.compliance.delta_free
        normal, force, sliding, margin = _coulomb(W, q, lam, first, self.friction, self.axes)
        friction = TangentialForces(force, sliding, margin)
        return Forces(effort, beta, slots, normal, friction)


@kernel
def _coulomb(
    W: Array, q: Array, lam: Array, first: int, mu: Array, axes: Array
) -> tuple[Array, Array, Bools, Array]:
    """Normal forces (r,) of the unit columns, and the arrays of their `TangentialForces`.

    Of slip and distance to slip the smaller one is rounding.

    Args:
        W: (m, m) compliance [m/N].
        q: (m,) row values without forces [m].
        lam: (m,) forces on all rows [N].
        first: row of the first unit column.
        mu: (r,) coefficients of friction.
        axes: (r, 3, 3) directions of the rows.
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
                force[k, i] += lam[at + t] * axes[k, t, i]
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
    system = robot.body.linearise(state, forces.effort, integration or robot.integration)
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
    reduced, extra, axes = space.reduce(rows.contacts), forces.extra, NO_AXES
    if len(extra) > 0:
        extra = rows.contacts.rows_of(forces.pushing)
    layout = robot.layout if effectors else row_layout(0, robot.n_a)
    size = layout.n_e + layout.n_a + len(reduced.delta)
    H, delta = np.empty((size, reduced.H.shape[1])), np.empty(size)  # (m, n), (m,)
    if effectors:
        H[layout.effectors], delta[layout.effectors] = rows.effectors.dense(), rows.effectors.delta
    H[layout.actuators], delta[layout.actuators] = rows.actuators.dense(), rows.actuators.delta
    H[layout.contacts], delta[layout.contacts] = reduced.H, reduced.delta
    if len(extra) > 0:
        of_units, values, axes = unit_rows(rows.contacts, extra, system.h, slid)
        H, delta = np.concatenate([H, of_units]), np.concatenate([delta, values])
    frictional = rows.contacts.relative is not None
    compliance = row_compliance(system, H, delta, frictional)
    laws = robot.actuators.laws
    if laws.springs is not None:
        compliance.spring(laws.springs, layout.actuators)
    rho = None
    if system.stiffened is not None and not frictional:
        rho = _with_stiffened(rho, system.stiffened, H[layout.actuators])
    return CondensedStep(
        state, system, rows, reduced, extra, axes, compliance, layout, laws, frictional, slid, rho,
    )  # fmt: skip


def recondensed(
    space: ContactSpace,
    step: CondensedStep,
    system: System,
    rho: Array | None = None,
) -> CondensedStep:
    """The same rows at the same state, condensed through another system.

    Args:
        space: basis of the contact forces.
        step: its rows and contacts are kept; obstacles that move are where they are after the new step.
        system: another scheme's, linearised at the same state; what contacts press has made none of its way.
        rho: (n_a,) stiffness along actuators in the tangent of the system; None: none.
    """
    rows, reduced, n_e = step.rows, step.reduced, step.layout.n_e
    if rows.contacts.found.surface is not None:
        rows = replace(rows, contacts=rows.contacts.later(system.h - step.system.h))
        reduced = space.reduce(rows.contacts)
    H, delta = step.compliance.H, [rows.effectors.delta[:n_e], rows.actuators.delta, reduced.delta]
    if len(step.extra) > 0:
        units = step.extra, step.axes, H[n_e + step.layout.n_a + len(reduced) :]
        delta.append(unit_values(rows.contacts, *units, system.h, None))
    compliance = row_compliance(system, H, np.concatenate(delta), step.frictional)
    if step.laws.springs is not None:
        compliance.spring(step.laws.springs, step.layout.actuators)
    if system.stiffened is not None and not step.frictional:
        rho = _with_stiffened(rho, system.stiffened, H[step.layout.actuators])
    return CondensedStep(
        step.state, system, rows, reduced, step.extra, step.axes, compliance, step.layout,
        step.laws, step.frictional, None, rho,
    )  # fmt: skip


def _with_stiffened(rho: Array | None, stiffened: tuple[Ints, Array], H: Array) -> Array | None:
    """Stiffness (n_a,) along actuators, with what a system has more on the diagonal of single drives.

    Of rows H (n_a, n) of the actuators; `rho` (n_a,) is added along them besides.
    """
    found = np.zeros(len(H)) if rho is None else rho.copy()
    alone = np.count_nonzero(H, axis=1) == 1  # no coupling of several drives
    for unknown, more in zip(*stiffened, strict=True):
        found[alone & (H[:, unknown] == 1.0)] += more
    return found if found.any() else rho


def unit_rows(
    contacts: ContactRows, chosen: Ints, h: float, slid: Array | None = None
) -> tuple[Array, Array, Array]:
    """Rows of single candidates: of their gaps (r,), and with friction of their slip too (3 r,).

    Args:
        contacts: candidates in range.
        chosen: (r,) some of them.
        h: time step [s].
        slid: (n,) displacement since the start of the step [m]; None: none.

    Returns:
        Dense H, values [m], and the axes (r, 3, 3) of rows with friction.
    """
    if contacts.relative is None:
        return contacts.rows.chosen(chosen), contacts.rows.delta[chosen], NO_AXES
    axes = contacts.found.axes(chosen)
    H = contacts.relative.along(axes, chosen)
    return H, unit_values(contacts, chosen, axes, H, h, slid), axes


def unit_values(
    contacts: ContactRows, chosen: Ints, axes: Array, H: Array, h: float, slid: Array | None
) -> Array:
    """Gaps (r,) of single candidates, and with friction their slip without motion of the robot (3 r,) [m].

    Args:
        contacts: candidates in range.
        chosen: (r,) some of them.
        axes: (r, 3, 3) of rows with friction.
        H: their rows.
        h: time step, in which obstacles move [s].
        slid: (n,) displacement since the start of the step [m]; None: none.
    """
    gaps, surface = contacts.rows.delta[chosen], contacts.found.surface
    if contacts.relative is None:
        return gaps
    values: Array = np.zeros(3 * len(chosen)) if slid is None else H @ slid
    if surface is not None:
        values -= h * np.einsum("rti,ri->rt", axes, surface[chosen]).ravel()
    values[::3] = gaps
    return values
