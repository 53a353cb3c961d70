"""What is given of the actuators: of each its position or its effort."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.numerics import Array, Bools


@dataclass(frozen=True, slots=True)
class Command:
    """Given positions and efforts; NaN where not given.

    Attributes:
        pull: (n_a,) positions [m, m³].
        tension: (n_a,) efforts [N, Pa].
    """

    pull: Array
    tension: Array

    @classmethod
    def of(cls, pull: Array | None, tension: Array | None) -> Command:
        """Positions (n_a,), efforts (n_a,), or both with NaN where the other one is given."""
        if pull is None:
            assert tension is not None
            return cls(np.full(len(tension), np.nan), tension)
        return cls(pull, np.full(len(pull), np.nan) if tension is None else tension)

    @property
    def by_force(self) -> Bools:
        """Which efforts are given: (n_a,) bool."""
        given: Bools = ~np.isnan(self.tension)
        return given

    @property
    def by_position(self) -> Bools:
        """Which positions are given: (n_a,) bool."""
        given: Bools = ~np.isnan(self.pull)
        return given

    def between(self, pull: Array, tension: Array, share: float) -> Command:
        """The same kind of command on the way from another state to this one.

        Args:
            pull: (n_a,) positions at the start.
            tension: (n_a,) efforts at the start.
            share: of the way, 0 to 1.
        """
        return Command(
            pull + share * (self.pull - pull), tension + share * (self.tension - tension)
        )
