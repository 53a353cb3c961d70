"""What the cables of a robot are brought to."""

from __future__ import annotations

from dataclasses import dataclass

from tauten.model import Report, Simulator
from tauten.model.numerics import Array


@dataclass(frozen=True, slots=True)
class CableLoad:
    """Pulled lengths or tensions of all cables, the other is None.

    Attributes:
        pull: (n_a,) [m].
        tension: (n_a,) [N].
    """

    pull: Array | None = None
    tension: Array | None = None

    def scaled(self, share: float) -> CableLoad:
        """The same kind of load, `share` times as large."""
        if self.pull is not None:
            return CableLoad(pull=share * self.pull)
        return CableLoad(tension=None if self.tension is None else share * self.tension)

    def step(self, simulator: Simulator, converged: bool = False) -> Report:
        """A step of a simulator under this load."""
        return simulator.step(self.pull, self.tension, converged)

    def settle(self, simulator: Simulator) -> Report:
        """Settle a simulator under this load."""
        return simulator.settle(self.pull, self.tension)
