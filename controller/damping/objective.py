"""The objective of a plan beside that of holding: what shows whether plans are of any use."""

from __future__ import annotations

from dataclasses import dataclass

from tauten.model.numerics import Array


@dataclass(frozen=True, slots=True)
class Energy:
    """The energy of the actuators of a cluster as the objective of one plan weighs it.

    Attributes:
        weight: (a, a) matrix ε s W_aa of the unknown forces [m²/N²].
        rho: (a,) stiffness along actuators in these, see `CondensedStep.efforts` [N/m].
        origin: (a,) positions where that stiffness pulls nothing [m].
    """

    weight: Array
    rho: Array
    origin: Array

    def of(self, efforts: Array, positions: Array) -> list[float]:
        """Twice the energy of each of some efforts (s, a) at positions (s, a), of any plan [m²]."""
        forces = efforts + self.rho * (positions - self.origin)  # (s, a)
        found: list[float] = (forces @ self.weight @ forces.T).diagonal().tolist()
        return found


@dataclass(frozen=True, slots=True)
class Objective:
    """Twice the objective of (T1) in a cluster, at the end of the horizon.

    Attributes:
        holding: where all actuators hold [m²].
        relaxed: the same a tick later, if they held in it [m²].
        before: that of holding for the goal of the decision before, with the weights of its plan [m²].
        planned: where they go to the plan [m²].
        share: of the way there that they go in the tick.
        energy: how it weighs efforts; None: it does not.
    """

    holding: float
    relaxed: float
    before: float
    planned: float
    share: float
    energy: Energy | None = None

    @property
    def gain(self) -> float:
        """What all of the way would decrease it by [m²]."""
        return self.holding - self.planned

    @property
    def predicted(self) -> float:
        """Decrease in the tick, as the first order has it [m²]."""
        return self.share * self.gain
