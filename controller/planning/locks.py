"""Locked actuators: a position or an effort is set from outside while the others are decided.

A lock moves towards its value no faster than the actuator's rate allows, and only where the robot follows: in
a hold a locked actuator stays where it is. In a decision the locked rows are
eliminated, so that the inverse problem keeps its form:

- an effort that is locked is a constant, which moves all rows;
- a position of a bilateral actuator is an equation, (T8) of `tauten.model.step.forward_step`;
- a cable locked at a length obeys 0 ≤ δ_a − pull ⟂ λ_a ≥ 0 as a contact does, and joins the contacts.

Limits of what is locked stay limits of the problem: the efforts of locked positions, the positions of locked
efforts.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from tauten.controller.qpcc import Qpcc, Solution, Start
from tauten.model import (
    Actuators,
    Command,
    CondensedStep,
    Limits,
    Robot,
    eliminate_rows,
    row_layout,
    sorted_rows,
)
from tauten.model.numerics import Array, Bools


class LockError(ValueError):
    """A lock that is not possible; the text says what is allowed."""


def number_of(robot: Robot, actuator: str) -> int:
    """Number of an actuator by its name.

    Raises:
        LockError: the robot has no such actuator.
    """
    names = robot.actuators.names
    if actuator not in names:
        raise LockError(
            f"{robot.name} has no actuator {str(actuator)[:40]!r}, its actuators are {', '.join(names)}"
        )
    return names.index(actuator)


@lru_cache(maxsize=64)
def no_locks(n_a: int) -> Command:
    """All of n_a actuators are decided; always the same object."""
    none = np.full(n_a, np.nan)
    none.flags.writeable = False
    return Command(none, none)


def locked(
    robot: Robot, locks: Command, actuator: str, position: float | None, force: float | None
) -> Command:
    """The locks with one more, or with another value of one.

    Args:
        robot: its limits bound what may be locked.
        locks: before.
        actuator: name.
        position: where it is locked [m, m³]; None: its effort is.
        force: effort at which it is locked [N, Pa]; None: its position is.

    Raises:
        LockError: no such actuator, not one of position and force, or a value beyond the limits.
    """
    i, limits = number_of(robot, actuator), robot.limits
    kind, label = robot.actuators.kinds[i], robot.actuators.labels[i]
    if (position is None) == (force is None):
        raise LockError(f"lock of {label}: give either a position or a force")
    positions, efforts = locks.position.copy(), locks.effort.copy()
    given = force if position is None else position
    try:
        value = float(given)  # type: ignore[arg-type]
    except (TypeError, ValueError) as error:
        raise LockError(f"lock of {label}: expected a number, found {given!r}") from error
    if position is not None:
        least, most, quantity = limits.position_min[i], limits.position_max[i], kind.position
        positions[i], efforts[i] = value, np.nan
    else:
        least, most, quantity = limits.effort_min[i], limits.effort_max[i], kind.effort
        positions[i], efforts[i] = np.nan, value
    if not least <= value <= most:
        raise LockError(
            f"lock of {label} at a {quantity.name} of {value:g} {quantity.unit}: allowed are {least:g} to "
            f"{most:g} {quantity.unit}"
        )
    return Command(positions, efforts)


def unlocked(robot: Robot, locks: Command, actuator: str) -> Command:
    """The locks without one.

    Raises:
        LockError: no such actuator, or one that is not locked.
    """
    i = number_of(robot, actuator)
    if not (locks.by_position[i] or locks.by_force[i]):
        raise LockError(f"{robot.actuators.labels[i]} is not locked")
    position, effort = locks.position.copy(), locks.effort.copy()
    position[i] = effort[i] = np.nan
    return Command(position, effort)


def locks_of_step(
    locks: Command, position: Array, effort: Array, step: CondensedStep, change: Array
) -> Command | None:
    """What locked actuators keep in a step; None: none is locked.

    Args:
        locks: positions and efforts.
        position: (n_a,) positions that left last.
        effort: (n_a,) efforts that left last.
        step: the step.
        change: (n_a,) largest change of a position in it.
    """
    if locks is no_locks(len(position)) or not any((locks.by_position | locks.by_force).tolist()):
        return None
    rows = step.layout.actuators
    return within_rate(locks, position, effort, step.compliance.W[rows, rows], change)


def within_rate(locks: Command, position: Array, effort: Array, W: Array, step: Array) -> Command:
    """What the locks ask of one step: their values, approached no faster than the rates allow.

    An effort changes by no more than moves its own actuator as far as its rate allows.

    Args:
        locks: positions and efforts.
        position: (n_a,) positions that left last.
        effort: (n_a,) efforts that left last.
        W: (n_a, n_a) compliance between the actuators.
        step: (n_a,) largest change of a position in a step.
    """
    diagonal = np.diag(W)
    reach = np.divide(step, diagonal, out=np.full_like(step, np.inf), where=diagonal > 0.0)
    return Command(
        np.clip(locks.position, position - step, position + step),
        np.clip(locks.effort, effort - reach, effort + reach),
    )


def resting(locks: Command, position: Array) -> Command:
    """What the locks ask of a hold: a locked position stays where it is, a locked effort asks nothing.

    Args:
        locks: positions and efforts.
        position: (n_a,) positions that left last.
    """
    return Command(np.where(locks.by_position, position, np.nan), np.full_like(position, np.nan))


def with_locks(held: Command, locks: Command) -> Command:
    """What actuators keep, with the values of locked ones."""
    by_force, by_position = locks.by_force, locks.by_position
    return Command(
        np.where(by_position, locks.position, np.where(by_force, np.nan, held.position)),
        np.where(by_force, locks.effort, np.where(by_position, np.nan, held.effort)),
    )


def ahead_of_locks(locks: Command, position: Array) -> Command:
    """What locked actuators keep over the horizon: positions stay where they are, pull (n_a,)."""
    return Command(np.where(locks.by_position, position, np.nan), locks.effort)


class LockedStep:
    """A condensed step without the rows of its locked actuators.

    Its rows are effectors, free actuators, and as contacts the locked cables, reduced contacts and unit
    columns.

    Attributes:
        W: compliance of these rows.
        delta_free: their values without forces.
        layout: where they are.
        free: (f,) numbers of the actuators that are decided.
    """

    def __init__(self, step: CondensedStep, locks: Command) -> None:
        """Eliminate the locked rows."""
        W, n_e = step.compliance.W, step.layout.n_e
        rows = sorted_rows(step, locks)
        self.free = np.flatnonzero(~(locks.by_position | locks.by_force))
        self.layout = row_layout(n_e, len(self.free))
        self._forced, self._effort = rows.forced, rows.effort
        self._zero, self._cables = rows.equal, rows.cables
        delta = rows.under_effort(W)
        self._kept = np.concatenate([np.arange(n_e), n_e + self.free, rows.unilateral])
        self._all_W, self._all_delta = W, delta
        self._rest = eliminate_rows(W, delta, self._kept, self._zero)
        self.W, self.delta_free = self._rest.W, self._rest.delta

    def bounded(self, problem: Qpcc, limits: Limits, actuators: Actuators) -> Qpcc:
        """An inverse problem of these rows with the limits of what is locked.

        Args:
            problem: of `W` and `delta_free`.
            limits: of all actuators.
            actuators: what the limits are called.
        """
        n_e, acting = self.layout.n_e, self.layout.acting
        zero, forced = self._zero - n_e, self._forced - n_e
        # positions of locked efforts, efforts of locked positions, tensions of locked cables
        cross = self._all_W[np.ix_(self._forced, self._zero)]
        moved = self._all_W[np.ix_(self._forced, self._kept)] + cross @ self._rest.gain
        at = self._all_delta[self._forced] + cross @ self._rest.offset
        taut = np.zeros((len(self._cables), len(self._kept)))
        first = self.layout.contacts.start
        taut[np.arange(len(taut)), first + np.arange(len(taut))] = 1.0
        cables = self._cables - n_e
        none = np.full(len(cables), -np.inf)
        low = [limits.position_min[forced] - at, limits.effort_min[zero] - self._rest.offset, none]
        high = [
            limits.position_max[forced] - at,
            limits.effort_max[zero] - self._rest.offset,
            limits.effort_max[cables],
        ]
        position, effort = actuators.position_names, actuators.effort_names
        names = [position[i][:2] for i in forced.tolist()]
        names += [(effort[i], effort[i]) for i in [*zero.tolist(), *cables.tolist()]]
        G = np.concatenate([moved[:, acting], self._rest.gain[:, acting], taut[:, acting]])
        return problem.limited(G, np.concatenate(low), np.concatenate(high), names)

    def start(self, effort: Array, pushing: Bools) -> Start:
        """Where the solver starts.

        Args:
            effort: (n_a,) efforts.
            pushing: (n_contacts,) contacts of the step that push.
        """
        taut = effort[self._cables - self.layout.n_e] > 0.0
        return Start(effort[self.free], np.concatenate([taut, pushing]))

    def with_cables(self, effort: Array, forces: Array) -> Array:
        """Forces on the contacts of the problem, the locked cables first.

        Args:
            effort: (n_a,) of all actuators.
            forces: on reduced contacts and unit columns, as in the step.
        """
        return np.concatenate([effort[self._cables - self.layout.n_e], forces])

    def forces(self, solution: Solution) -> Array:
        """Forces on all rows of the step (m,), from those of the problem."""
        kept = np.concatenate([np.zeros(self.layout.n_e), solution.lam_a, solution.beta])
        lam = np.zeros(len(self._all_delta))
        lam[self._kept], lam[self._forced] = kept, self._effort
        lam[self._zero] = self._rest.gain @ kept + self._rest.offset
        return lam
