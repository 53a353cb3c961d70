"""What the cables of a robot are brought to."""

from __future__ import annotations

from dataclasses import dataclass

from tauten.model import Report, Simulator
from tauten.model.numerics import Array


@dataclass(frozen=True, slots=True)
class CableLoad:
    """Pulled lengths or tensions of all cables, the other is None.

    Attributes:
        position: (n_a,) [m].
        effort: (n_a,) [N].
    """

    position: Array | None = None
    effort: Array | None = None

    def scaled(self, share: float) -> CableLoad:
        """The same kind of load, `share` times as large."""
        if self.position is not None:
            return CableLoad(position=share * self.position)
        return CableLoad(effort=None if self.effort is None else share * self.effort)

    def step(self, simulator: Simulator, converged: bool = False) -> Report:
        """A step of a simulator under this load."""
        return simulator.step(self.position, self.effort, converged)

    def settle(self, simulator: Simulator) -> Report:
        """Settle a simulator under this load."""
        return simulator.settle(self.position, self.effort)
