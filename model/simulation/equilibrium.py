"""The merit function of an equilibrium, and the line search on it.

An equilibrium under given positions is a minimum of the potential Π(q) of elasticity, gravity and outer
forces under the constraints c(q) ≥ 0 of cables, δ_a − pull, and contacts, δ_c, and c(q) = 0 of actuators that
pull and push; the work λ_aᵀ δ_a of given efforts and the energy of springs join the potential. A linearised
step solves the quadratic program of that problem with the tangent as Hessian, so that its direction decreases
the exact penalty function

    φ(q) = Π(q) − λ_aᵀ δ_a(q) + Σ w_i max(0, −c_i(q)) + Σ w_j |c_j(q)|,   w > |λ|

wherever the tangent is positive definite (Nocedal and Wright, Numerical Optimization, 2006, 18.3).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

import numpy as np

from tauten.model.numerics import Array
from tauten.model.robot import Robot
from tauten.model.signals import Command
from tauten.model.state import State
from tauten.model.step import ContactSpace, Forces, PredictedStep
from tauten.model.system import System

WEIGHT = 2.0  # of a constraint's violation, relative to the largest force on it
HALVINGS = 6  # of a step at most


class Ending(Enum):
    """How the search for an equilibrium ended."""

    SETTLED = "settled"
    BUCKLED = "the equilibrium is unstable, and no stable one was found beside it"
    LIMIT_POINT = "the tangent loses definiteness before the load is reached"
    INVERTED = "elements turn inside out"
    NO_EQUILIBRIUM = "no forces of actuators and contacts meet their constraints"
    OUT_OF_ITERATIONS = "the steps do not become small"
    NOT_FINITE = "the state has diverged"


@dataclass(frozen=True, slots=True)
class Report:
    """How a step or a settling went.

    Attributes:
        converged: whether contact, and for settling the equilibrium, met its tolerance, and the state has not
            diverged.
        iterations: linearised steps taken, of all attempts.
        movement: largest displacement of a node in the last step [m].
        residual: complementarity of the contacts [m].
        deepest_gap: smallest predicted gap [m], +inf without any candidate in range.
        extra_columns: unit columns in the last step.
        ending: how it ended; for a step, whether it met its constraints.
        share: of the way from the load before to the command that the state has come; 1 at the command.
    """

    converged: bool
    iterations: int
    movement: float
    residual: float
    deepest_gap: float
    extra_columns: int
    ending: Ending
    share: float


@dataclass(frozen=True, slots=True)
class Found:
    """Where a search or an iterated step ended.

    Attributes:
        state: there; of a search at standstill.
        forces: constraint forces there.
        report: how it went.
        last: its last step, at whose start contacts were detected; None where there was none.
    """

    state: State
    forces: Forces
    report: Report
    last: PredictedStep | None


class Merit:
    """The merit φ along the steps of one command; weights only grow, so that φ does not cycle."""

    def __init__(
        self,
        robot: Robot,
        space: ContactSpace,
        command: Command,
        energy: Callable[[State], float],
        moved: Callable[[State, System, Array], State],
    ) -> None:
        """Start with no weights.

        The energy of a state [J] is minimised under the constraints; a system and a change of velocity (n,)
        lead to the state that `moved` gives.
        """
        self._moved = moved
        self._robot, self._space, self._command, self._energy = robot, space, command, energy
        self._weights = np.zeros(robot.n_a)
        self._modes = np.zeros(space.k)
        self._slots = np.zeros(robot.n_c)
        self._touching = False

    def observe(self, solved: PredictedStep) -> None:
        """Raise the weights above the forces of a step."""
        forces = solved.step.split(solved.lam, self._space.k)
        self._weights = np.maximum(self._weights, WEIGHT * np.abs(forces.effort))
        self._modes = np.maximum(self._modes, WEIGHT * forces.beta)
        self._slots[forces.extra] = np.maximum(
            self._slots[forces.extra], WEIGHT * forces.extra_beta
        )
        self._touching = bool((self._modes > 0.0).any() or (self._slots > 0.0).any())

    def share(self, solved: PredictedStep, largest: float) -> float:
        """Which share of a step decreases the merit: `largest`, or half of it some times.

        Where none does, the one with the smallest merit. Shares with forces that are not finite are
        refused; 0.0 where all are.
        """
        state, share = solved.step.state, largest
        before = self._energy(state) + self._constraints(state)
        best, least = 0.0, np.inf
        for _ in range(HALVINGS + 1):
            after = self._moved(state, solved.step.system, share * solved.dv)
            change = self._energy(after) + self._constraints(after) - before
            if change < 0.0:
                return share
            if change < least:
                best, least = share, change
            share *= 0.5
        return best

    def _constraints(self, state: State) -> float:
        """Work of given efforts, energy of springs and weighted violations [J]."""
        rows = self._robot.rows(state, self._touching, effectors=False)
        laws = self._robot.actuators.laws
        value = laws.penalty(self._command, rows.actuators.delta, self._weights)
        if self._touching:
            gaps = rows.contacts
            value += float(self._slots[gaps.slots] @ np.maximum(-gaps.rows.delta, 0.0))
            reduced = self._space.reduce(gaps)
            value += float(self._modes[reduced.modes] @ np.maximum(-reduced.delta, 0.0))
        return value


def make_report(
    robot: Robot,
    state: State,
    result: PredictedStep,
    iterations: int,
    movement: float,
    ending: Ending = Ending.SETTLED,
) -> Report:
    """The report of a step or a search.

    Args:
        robot: the robot.
        state: that it led to.
        result: the last step.
        iterations: linearised steps taken.
        movement: largest displacement of a node in the last step [m].
        ending: how it ended, without the reason that the last step shows.
    """
    met = result.converged and result.within_tolerance
    if not met:
        ending = Ending.NO_EQUILIBRIUM
    elif ending in (Ending.OUT_OF_ITERATIONS, Ending.NOT_FINITE):
        if robot.body.inverted(state) > 0:
            ending = Ending.INVERTED
        elif not result.step.system.exact:
            ending = Ending.LIMIT_POINT
    converged = ending is Ending.SETTLED
    return Report(
        converged=converged,
        iterations=iterations,
        movement=movement,
        residual=result.residual,
        deepest_gap=result.deepest_gap,
        extra_columns=len(result.step.extra),
        ending=ending,
        share=1.0 if converged else 0.0,
    )
