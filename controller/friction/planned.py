"""Plans whose contacts have friction: the inverse problem of a QPCC, and its answer as a QPCC's solution."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.controller.friction.problem import FrictionInverse
from tauten.controller.friction.solve import (
    FrictionSettings,
    InverseSolution,
    solve_friction_inverse,
)
from tauten.controller.qpcc import Certificate, Qpcc, Solution, Status
from tauten.model import FrictionBlocks
from tauten.model.numerics import Array

EXACTLY = 1e-7  # of the robot's size, error of contact forces
ARRIVED = 1e-5  # of the robot's size, distance from a target below which nothing is looked for


@dataclass(frozen=True, slots=True)
class PlanContacts:
    """What a plan has besides its QPCC where contacts have friction.

    Attributes:
        friction: (k,) coefficients that it counts on.
        forces: (s + 3 k,) contact forces of the last step.
        exact: error of the natural map up to which forces are exact [m].
        enough: objective that need not become lower [m²].
        energy: (n_a,) curvatures of the energy of the actuators.
        settings: of the search.
    """

    friction: Array
    forces: Array
    exact: float
    enough: float
    energy: Array
    settings: FrictionSettings

    @classmethod
    def of(
        cls,
        blocks: FrictionBlocks,
        rows: int,
        share: float,
        size: float,
        energy: Array,
        settings: FrictionSettings,
    ) -> PlanContacts:
        """Those of a plan, the last ones of which have friction.

        Args:
            blocks: contacts with friction, with their forces in the last step.
            rows: of all contacts.
            share: of the coefficients, that the plan counts on.
            size: of the robot [m].
            energy: (n_a,) curvatures of the energy of the actuators.
            settings: of the search.
        """
        forces, enough = np.zeros(rows), 0.5 * (ARRIVED * size) ** 2
        forces[rows - len(blocks.r) :] = blocks.r
        return cls(share * blocks.mu, forces, EXACTLY * size, enough, energy, settings)

    def solve(
        self,
        program: Qpcc,
        lam: Array,
        forces: Array | None = None,
        guess: Solution | None = None,
    ) -> Solution:
        """The best efforts found.

        Args:
            program: limits and objective; its rows are the contacts.
            lam: (n_a,) efforts of holding.
            forces: (s + 3 k,) contact forces to start from; None: those of the last step.
            guess: answer to nearly the same problem, whose rows are the first ones of this.
        """
        problem = FrictionInverse(program, self.friction, self.exact, self.enough, self.energy)
        near = None
        if guess is not None:
            near = guess.lam_a, np.zeros(len(self.forces))
            near[1][: len(guess.beta)] = guess.beta
        start = self.forces if forces is None else forces
        found = solve_friction_inverse(problem, lam, start, self.settings, near)
        return as_solution(program, found)


def as_solution(program: Qpcc, found: InverseSolution) -> Solution:
    """An answer as that of a QPCC with the same rows; its pieces are the normal and single rows that push.

    Args:
        program: of the problem.
        found: its answer.
    """
    rows = program.G @ np.concatenate([found.lam_a, found.forces])
    excess = np.maximum(rows - program.g_hi, program.g_lo - rows)
    limits = np.abs(np.concatenate([program.g_lo, program.g_hi]))
    largest = float(limits[np.isfinite(limits)].max(initial=0.0))
    gaps = float(np.abs(program.m).max(initial=0.0))
    certificate = Certificate(
        primal=max(0.0, float(excess.max(initial=0.0))) / (largest or 1.0),
        complementarity=found.error / (gaps or 1.0),
        stationarity=float(np.sqrt(max(found.gain, 0.0))),
        deepest_gap=np.inf,
    )
    infeasible = found.status is Status.INFEASIBLE
    conflict = tuple(
        program.name_of_row(i, bool(rows[i] > program.g_hi[i]))
        for i in np.flatnonzero(infeasible & (excess > 1e-6 * largest)).tolist()
    )
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
