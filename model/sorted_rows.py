"""The rows of a step by the law that they obey, where positions and efforts of actuators are given.

With the value δ of a row less the position that is given, and its force λ:

| rows | law |
|---|---|
| effort given | λ is known |
| position of a bilateral actuator given | δ = 0, λ of either sign |
| position of a cable given | 0 ≤ δ ⟂ λ ≥ 0: its path may be shorter, and it only pulls |
| contact | 0 ≤ δ ⟂ λ ≥ 0 |
| nothing given | decided by the caller |
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.condensed_step import CondensedStep
from tauten.model.interface import Command
from tauten.model.numerics import Array, Ints


@dataclass(frozen=True, slots=True)
class SortedRows:
    """Rows of a step by their law.

    Attributes:
        forced: (f,) rows whose effort is given.
        effort: (f,) these efforts [N, Pa].
        equal: (e,) rows of bilateral actuators whose position is given.
        cables: (u,) rows of cables whose position is given.
        contacts: (c,) rows of contacts.
        decided: (d,) rows of actuators of which nothing is given.
        delta: (m,) row values without forces, less the positions that are given.
    """

    forced: Ints
    effort: Array
    equal: Ints
    cables: Ints
    contacts: Ints
    decided: Ints
    delta: Array

    @property
    def unilateral(self) -> Ints:
        """Rows (u + c,) with 0 ≤ δ ⟂ λ ≥ 0."""
        return np.concatenate([self.cables, self.contacts])

    def under_effort(self, W: Array) -> Array:
        """`delta` (m,) under the efforts that are given, with the compliance W (m, m)."""
        if len(self.forced) == 0:
            return self.delta
        moved: Array = self.delta + W[:, self.forced] @ self.effort
        return moved


def sorted_rows(step: CondensedStep, command: Command) -> SortedRows:
    """Sort the rows of a step.

    Args:
        step: rows, compliance and laws of the actuators.
        command: position or effort of each actuator, or neither.
    """
    layout, bilateral = step.layout, step.laws.bilateral
    by_force, by_position = command.by_force, command.by_position
    delta = step.compliance.delta_free.copy()
    delta[layout.actuators] -= np.where(by_position, command.position, 0.0)
    return SortedRows(
        forced=layout.of_actuators(by_force),
        effort=command.effort[by_force],
        equal=layout.of_actuators(by_position & bilateral),
        cables=layout.of_actuators(by_position & ~bilateral),
        contacts=layout.of_contacts(len(delta)),
        decided=layout.of_actuators(~by_force & ~by_position),
        delta=delta,
    )
