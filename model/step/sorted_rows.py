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

from tauten.model.numerics import Array, Bools, Ints, kernel
from tauten.model.signals import Command
from tauten.model.step.condensed_step import CondensedStep


@dataclass(frozen=True, slots=True)
class SortedRows:
    """Rows of a step by their law.

    Attributes:
        forced: (f,) rows whose effort is given.
        effort: (f,) these efforts [N, Pa].
        equal: (e,) rows of bilateral actuators whose position is given.
        unilateral: (u + c,) rows with 0 ≤ δ ⟂ λ ≥ 0: of cables whose position is given, then of contacts.
        n_cables: how many of them are cables, u.
        delta: (m,) row values without forces, less the positions that are given.
    """

    forced: Ints
    effort: Array
    equal: Ints
    unilateral: Ints
    n_cables: int
    delta: Array

    @property
    def cables(self) -> Ints:
        """Rows (u,) of cables whose position is given."""
        return self.unilateral[: self.n_cables]

    @property
    def contacts(self) -> Ints:
        """Rows (c,) of contacts."""
        return self.unilateral[self.n_cables :]

    def under_effort(self, W: Array) -> Array:
        """`delta` (m,) under the efforts that are given, with the compliance W (m, m)."""
        if len(self.forced) == 0:
            return self.delta
        moved: Array = self.delta + W[:, self.forced] @ self.effort
        return moved


def sorted_rows(step: CondensedStep, command: Command) -> SortedRows:
    """Sort the rows of a step by a command: position or effort of each actuator, or neither."""
    position, effort, n_e = command.position, command.effort, step.layout.n_e
    free, bilateral = step.compliance.delta_free, step.laws.bilateral
    return SortedRows(*sort_rows(free, position, effort, bilateral, n_e))


@kernel
def sort_rows(
    delta_free: Array, position: Array, effort: Array, bilateral: Bools, n_e: int
) -> tuple[Ints, Array, Ints, Ints, int, Array]:
    """The arrays of `SortedRows`, in their order.

    Args:
        delta_free: (m,) row values without forces.
        position: (n_a,) that are given, NaN where not.
        effort: (n_a,) likewise.
        bilateral: (n_a,) actuators that pull and push.
        n_e: effector rows, which come first.
    """
    by_force, by_position = ~np.isnan(effort), ~np.isnan(position)
    delta, end = delta_free.copy(), n_e + len(position)
    delta[n_e:end] -= np.where(by_position, position, 0.0)
    cables = n_e + np.flatnonzero(by_position & ~bilateral)
    return (
        n_e + np.flatnonzero(by_force),
        effort[by_force],
        n_e + np.flatnonzero(by_position & bilateral),
        np.concatenate((cables, np.arange(end, len(delta)))),
        len(cables),
        delta,
    )
