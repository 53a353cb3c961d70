"""What is given of the actuators: of each its position or its effort."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.numerics import Array, Bools


@dataclass(frozen=True, slots=True)
class Command:
    """Given positions and efforts; NaN where not given.

    Attributes:
        position: (n_a,) positions [m, m³].
        effort: (n_a,) efforts [N, Pa].
    """

    position: Array
    effort: Array

    @classmethod
    def of(cls, position: Array | None, effort: Array | None) -> Command:
        """Positions (n_a,), efforts (n_a,), or both with NaN where the other one is given."""
        if position is None:
            assert effort is not None
            return cls(np.nan * effort, effort)
        return cls(position, np.nan * position if effort is None else effort)

    @classmethod
    def either(cls, by_force: Bools, position: Array, effort: Array) -> Command:
        """The efforts of some actuators and the positions of the others.

        Args:
            by_force: (n_a,) which of them get efforts.
            position: (n_a,) positions [m, m³].
            effort: (n_a,) efforts [N, Pa].
        """
        position, effort = position.copy(), effort.copy()
        position[by_force], effort[~by_force] = np.nan, np.nan
        return cls(position, effort)

    @property
    def by_force(self) -> Bools:
        """Which efforts are given: (n_a,) bool."""
        given: Bools = ~np.isnan(self.effort)
        return given

    @property
    def by_position(self) -> Bools:
        """Which positions are given: (n_a,) bool."""
        given: Bools = ~np.isnan(self.position)
        return given

    def starting(self, before: Command) -> tuple[Array, Array]:
        """Positions and efforts (n_a,) at the start of the way from another command to this one.

        Where that gives none, those of this one hold all the way.
        """
        position, effort = before.position.copy(), before.effort.copy()
        for start, end in ((position, self.position), (effort, self.effort)):
            missing = np.isnan(start)
            start[missing] = end[missing]
        return position, effort

    def between(self, position: Array, effort: Array, share: float) -> Command:
        """The same kind of command on the way from another state to this one.

        Args:
            position: (n_a,) positions at the start.
            effort: (n_a,) efforts at the start.
            share: of the way, 0 to 1.
        """
        return Command(
            position + share * (self.position - position), effort + share * (self.effort - effort)
        )
