"""What every part of the search for efforts works on: contacts, the QP, the budget, and exact points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.controller.friction.effort_step import (
    EffortArrays,
    EffortStep,
    effort_arrays,
    effort_change,
    effort_qp,
    effort_reach,
    effort_step,
)
from tauten.controller.friction.exact import WIDE, exact_point, point_at
from tauten.controller.friction.problem import (
    EffortPoint,
    FrictionInverse,
    InverseContacts,
    contact_rows,
    inverse_contacts,
    largest_limit,
)
from tauten.controller.qpcc import Backend, Budget, Qp, qp_backend
from tauten.model.friction import Width
from tauten.model.numerics import Array, Ints, kernel

WITHIN = 1e-7  # of the largest limit, by which a point may exceed one
NARROWEST = 1e-300  # range of an effort [N, Pa] that changes are divided by


@dataclass(frozen=True, slots=True)
class EffortSearch:
    """An inverse problem and how far the search for its efforts may go.

    Attributes:
        problem: the inverse problem.
        contacts: with three rows each.
        place: (s + 3 k,) where each row of the problem is among these.
        arrays: objective and limits for kernels.
        solver: name of the QP library, or a function, for QPs that the kernel does not solve.
        span: (n_a,) range of the efforts [N, Pa]; next to nothing of one that has none.
        allowed: excess over the limits that counts as none, in the unit of their rows.
        budget: linear systems and time.
    """

    problem: FrictionInverse
    contacts: InverseContacts
    place: Ints
    arrays: EffortArrays
    solver: str | Backend
    span: Array
    allowed: float
    budget: Budget

    def rows(self, r: Array) -> Array:
        """Forces (3 m,) on the problem's rows (s + 3 k,)."""
        chosen: Array = r[self.place]
        return chosen

    def step(self, lam: Array, r: Array, slope: Array, trust: Array) -> EffortStep | None:
        """The best change of the efforts; None where the QP has no solution.

        Args:
            lam: (n_a,) efforts.
            r: (3 m,) contact forces there, or where the law of contact leads from them.
            slope: (3 m, n_a) of the forces.
            trust: (n_a,) largest change of each effort.
        """
        solved, change, gain = effort_step(self.arrays, lam, r, slope, trust)
        if solved:
            return EffortStep(change, gain)
        qp = effort_qp(self.arrays, lam, r, slope, trust)
        answer = qp_backend(self.solver)(Qp(qp.H, qp.f, qp.A, qp.lower, qp.upper))
        if answer.infeasible or not np.isfinite(answer.y).all():
            return None
        return EffortStep(*effort_change(qp, answer.y))

    def reach(self, point: EffortPoint) -> tuple[float, float]:
        """How far one effort within the limits moves the effectors, on a piece, and open contacts, at most.

        Args:
            point: exact, of the piece.
        """
        energy = self.problem.energy
        energy = np.zeros(len(self.span)) if energy is None else energy.diagonal().copy()
        return effort_reach(self.arrays, point.slope, self.contacts.W_ca, self.span, energy)

    def away(self, point: EffortPoint) -> float:
        """The objective of a point without the energy of its efforts."""
        energy, lam = self.problem.energy, point.lam
        return point.objective - (0.0 if energy is None else 0.5 * float(lam @ energy @ lam))

    def bounded(self, lam: Array) -> Array:
        """Efforts (n_a,) within their bounds."""
        within: Array = np.minimum(
            np.maximum(lam, self.problem.program.lb), self.problem.program.ub
        )
        return within

    def feasible(self, point: EffortPoint) -> bool:
        """Whether a point is within the limits."""
        return point.excess <= self.allowed

    def exact(
        self, lam: Array, start: Array, wide: Width = WIDE, needed: bool = False
    ) -> EffortPoint | None:
        """The exact point at efforts, brought within their bounds; None where none is found.

        With the budget used up only a few steps on the exact law are taken, unless the point is needed.

        Args:
            lam: (n_a,) efforts.
            start: (3 m,) forces to start from.
            wide: of the smoothed law, where the exact one fails.
            needed: whether it is looked for whatever the budget.
        """
        return exact_point(self.contacts, self.arrays, lam, start, self.budget, wide, needed)

    def along(
        self, point: EffortPoint, change: Array, newton: int, farthest: float
    ) -> EffortPoint | None:
        """The exact point after a change of the efforts; None where steps on the exact law do not find it.

        Args:
            point: exact; its piece tells where they start.
            change: (n_a,) of the efforts.
            newton: steps, at most.
            farthest: error of the natural map after the change on the piece, beyond which it has ended there.
        """
        ahead, begin = point.r + point.slope @ change, self.budget.time.clock()
        found, there, systems = point_at(
            self.contacts, self.arrays, point.lam + change, ahead, newton, farthest
        )
        self.budget.count(systems, begin)
        return there if found else None


def effort_search(problem: FrictionInverse, solver: str | Backend, budget: Budget) -> EffortSearch:
    """Set up the search of a problem.

    Args:
        problem: the inverse problem.
        solver: name of the QP library, or a function.
        budget: linear systems and time.
    """
    p = problem.program
    contacts = inverse_contacts(problem)
    span = np.maximum(effort_span(contacts, p.lb, p.ub), NARROWEST)
    largest = largest_limit(p.g_lo, p.g_hi)
    return EffortSearch(
        problem, contacts, contact_rows(problem),
        effort_arrays(problem), solver, span, WITHIN * largest, budget,
    )  # fmt: skip


@kernel
def effort_span(contacts: InverseContacts, lb: Array, ub: Array) -> Array:
    """Range of the efforts (n_a,); without limits one that moves contacts ten times as far as they are apart.

    Args:
        contacts: the contacts.
        lb: (n_a,) limits of the efforts.
        ub: (n_a,) limits of the efforts.
    """
    span, apart = ub - lb, 10.0 * np.abs(contacts.q).max()
    for j in range(len(span)):
        if not span[j] < np.inf:
            moved = np.abs(contacts.W_ca[:, j]).max()
            span[j] = max(apart / moved if moved > 0.0 else 0.0, 1.0)
    return span
