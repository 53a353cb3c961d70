"""Plans whose contacts have friction: the inverse problem of a QPCC, and its answer as a QPCC's solution.

Where its search was cut is kept in a way that a plan of another tick can go on from.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from tauten.controller.friction.problem import FrictionInverse, largest_limit
from tauten.controller.friction.solve import (
    FrictionSettings,
    InverseSolution,
    solve_friction_inverse,
)
from tauten.controller.friction.trials import CutSearch
from tauten.controller.qpcc import Certificate, Qpcc, Solution, Status
from tauten.model import CondensedStep, Forces, PredictedStep, unit_start
from tauten.model.numerics import Array, Ints

EXACTLY = 1e-7  # of the size of the largest part, error of contact forces
ARRIVED = 1e-5  # of that size, distance from a target below which nothing is looked for
MET = 1e-3  # of that size, distance from a target that needs no contact


def no_slots() -> Ints:
    """Slots of no contact (0,)."""
    return np.zeros(0, np.int64)


def with_known_columns(step: CondensedStep, held: CondensedStep, pushed: Ints) -> CondensedStep:
    """A step with friction, with the unit columns that joined in its hold or pushed in the last plan.

    Contacts of a plan that a hold does not touch would join after a first search otherwise, in each tick.

    Args:
        step: over the horizon.
        held: the same with the columns that joined in the hold, with friction unless no forces were found.
        pushed: slots of the unit columns that pushed in the last plan.
    """
    joins = np.zeros(len(step.rows.contacts.slots), np.bool_)
    joins[held.extra] = joins[step.rows.contacts.rows_of(pushed)] = True
    step = held if held.frictional else step
    joins[step.extra] = False
    return step.with_unit_columns(np.flatnonzero(joins)) if joins.any() else step


def pushed_slots(predicted: PredictedStep) -> Ints:
    """Slots of the unit columns that push in a step with friction; none in one without.

    Args:
        predicted: the step.
    """
    step, lam = predicted.step, predicted.lam
    if not step.frictional:
        return step.extra[:0]  # none
    slots: Ints = step.rows.contacts.slots[
        step.extra[lam[len(lam) - 3 * len(step.extra) :: 3] > 0.0]
    ]
    return slots


@dataclass(frozen=True, slots=True)
class CutPlan:
    """Where the search of a plan was cut; another plan can go on from there, with other contacts in range.

    Attributes:
        search: where; None: it has not begun.
        forces: efforts of all actuators and contact forces there; None: its path has not begun.
        seeking: whether the plan seeks contact.
    """

    search: CutSearch | None
    forces: Forces | None = None
    seeking: bool = False

    @classmethod
    def of(cls, search: CutSearch, step: CondensedStep, decided: Ints, columns: int) -> CutPlan:
        """That of a plan.

        Args:
            search: where it was cut.
            step: with the contacts of the plan.
            decided: (f,) numbers of the actuators that it decides.
            columns: of the basis of contact forces.
        """
        if search.path is None:
            return cls(search)
        lam, units = np.zeros(len(step.compliance)), 3 * len(step.extra)
        lam[step.layout.actuators.start + decided] = search.path.state.lam
        lam[len(lam) - units :] = search.path.state.r[len(search.path.state.r) - units :]
        return cls(search, step.split(lam, columns))

    def on(self, step: CondensedStep, decided: Ints, rows: int) -> CutSearch | None:
        """Where a plan goes on; None where it begins anew, as it does where others are locked.

        Args:
            step: with the contacts of the plan.
            decided: (f,) numbers of the actuators that it decides.
            rows: of its contacts.
        """
        if self.search is None or self.search.path is None or self.forces is None:
            return self.search
        path = self.search.path
        if len(path.state.lam) != len(decided):
            return None
        r, unit = np.zeros(rows), unit_start(step, self.forces)
        r[rows - len(unit) :] = unit
        state = path.state._replace(lam=self.forces.effort[decided], r=r)
        return replace(self.search, path=replace(path, state=state))


@dataclass(slots=True)
class PlanSearch:
    """The search of a plan whose contacts have friction; each problem goes on where the one before was cut.

    Attributes:
        friction: (k,) coefficients that the plan counts on, of the last contacts.
        lam: (n_a,) efforts of holding.
        forces: (s + 3 k,) contact forces from which those of holding are looked for.
        size: of the robot's largest part [m].
        energy: (n_a, n_a) curvature of the energy of the actuators.
        settings: of the search.
        guess: answer before the last contacts joined; None: there is none.
        cut: where the last search was cut; None: it was not.
    """

    friction: Array
    lam: Array
    forces: Array
    size: float
    energy: Array
    settings: FrictionSettings
    guess: Solution | None
    cut: CutSearch | None

    def __call__(self, problem: Qpcc, near: Solution | None) -> Solution:
        """The best efforts found.

        Args:
            problem: limits and objective; its rows are the contacts.
            near: the point that violates the limits least, where that is known.
        """
        lam, start, guess = self.lam, self.forces, None
        if near is not None:
            lam, start = near.lam_a, near.beta
        elif self.guess is not None:  # its rows are the first ones of this problem
            guess = self.guess.lam_a, np.zeros(len(start))
            guess[1][: len(self.guess.beta)] = self.guess.beta
        enough, met = (0.5 * (distance * self.size) ** 2 for distance in (ARRIVED, MET))
        exact, energy = EXACTLY * self.size, self.energy
        asked = FrictionInverse(problem, self.friction, exact, enough, met, energy)
        found = solve_friction_inverse(asked, lam, start, self.settings, guess, self.cut)
        self.cut = found.cut
        return as_solution(problem, found)


def as_solution(program: Qpcc, found: InverseSolution) -> Solution:
    """An answer as that of a QPCC with the same rows; its pieces are the normal and single rows that push.

    Args:
        program: of the problem.
        found: its answer.
    """
    largest, gaps = largest_limit(program.g_lo, program.g_hi), float(np.abs(program.m).max())
    certificate = Certificate(
        primal=found.excess / (largest or 1.0),
        complementarity=found.error / (gaps or 1.0),
        stationarity=math.sqrt(max(found.gain, 0.0)),
        deepest_gap=np.inf,
    )
    conflict: tuple[str, ...] = ()
    if found.status is Status.INFEASIBLE:
        rows = program.G @ np.concatenate([found.lam_a, found.forces])
        excess = np.maximum(rows - program.g_hi, program.g_lo - rows)
        (exceeded,) = np.nonzero(excess > 1e-6 * largest)
        names = (program.name_of_row(i, bool(rows[i] > program.g_hi[i])) for i in exceeded.tolist())
        conflict = tuple(names)
    return Solution(
        found.lam_a,
        found.forces,
        found.status,
        certificate,
        found.objective,
        found.solves,
        found.forces > 0.0,
        conflict,
    )
