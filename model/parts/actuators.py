"""The actuators of several parts: those of each part, one after the other."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tauten.model.actuators import ActuatorRows, Coupling
from tauten.model.numerics import Array, Ints
from tauten.model.parts.motion import PartsMotion, slices, stacked
from tauten.model.parts.part import Placement
from tauten.model.points import Motion
from tauten.model.rows import Rows


@dataclass(frozen=True, slots=True, eq=False)
class PartsActuators:
    """The actuators of several parts; an `ActuatorRows`.

    Attributes:
        parts: actuators of each part.
        placements: where the parts stand.
        columns: unknowns of each part.
        coupling: of the actuators of all parts; None: each is a motor of its own.
        spans: the actuators of each part among those of all, before they are coupled.
    """

    parts: tuple[ActuatorRows, ...]
    placements: tuple[Placement, ...]
    columns: tuple[slice, ...]
    coupling: Coupling | None
    spans: tuple[slice, ...] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "spans", slices([part.n_a for part in self.parts]))

    @property
    def n_a(self) -> int:
        """Number of motors, the length of λ_a."""
        return sum(part.n_a for part in self.parts) if self.coupling is None else self.coupling.n_a

    def motors(self, members: Ints) -> Ints:
        """The motors (m,) that drive actuators (m,) of the parts; −1 remains −1."""
        return members if self.coupling is None else self.coupling.motors_of(members)

    @property
    def motor_coordinates(self) -> Ints:
        """Degrees of freedom that a motor holds: those of drives and drums."""
        pairs = zip(self.parts, self.columns, strict=True)
        return np.concatenate([part.motor_coordinates + span.start for part, span in pairs])

    @property
    def segment_owners(self) -> Ints:
        """The actuator of every segment that `segments` gives: (s,)."""
        pairs = zip(self.parts, self.spans, strict=True)
        return self.motors(
            np.concatenate([part.segment_owners + span.start for part, span in pairs])
        )

    def segments(self, motion: Motion[Any]) -> Array:
        """Segments by which actuators are drawn: (s, 2, 3) [m]."""
        assert isinstance(motion, PartsMotion)
        every = zip(self.parts, motion.parts, self.placements, strict=True)
        return np.concatenate([place.points(part.segments(own)) for part, own, place in every])

    def rows(self, motion: Motion[Any]) -> Rows:
        """Positions δ_a and H_a: Rows of (n_a, n)."""
        assert isinstance(motion, PartsMotion)
        rows = [part.rows(own) for part, own in zip(self.parts, motion.parts, strict=True)]
        single = rows[0]
        if len(rows) > 1:
            delta = np.concatenate([part.delta for part in rows])
            single = Rows(stacked([part.H for part in rows]), delta)
        return single if self.coupling is None else self.coupling.rows(single)

    def split(self, effort: Array | None) -> list[Array | None]:
        """Efforts (n_a,) of the actuators of each part; None: of none."""
        if effort is None:
            return [None] * len(self.parts)
        if self.coupling is not None:
            effort = self.coupling.efforts(effort)
        return [effort[span] for span in self.spans]
