"""Couplings: motors that drive several actuators.

With the gains C, member actuators i and motors m,

    δ_m = Σ_i C_mi δ_i,   λ_i = offset_i + Σ_m C_mi λ_m                                      (A2)

so that the work of a motor is that on its members, apart from that of the constant offsets. An actuator
without a coupling is a motor of its own with the gain one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from tauten.model.numerics import Array, Ints
from tauten.model.rows import Rows
from tauten.model.schema import CouplingSettings, RobotConfig


@dataclass(frozen=True, slots=True)
class Coupling:
    """Gains and offsets of the motors of a robot.

    Attributes:
        gains: C (n_a, members).
        offsets: (members,) efforts on the members where the motors have none [N, Pa].
    """

    gains: sp.csr_array
    offsets: Array

    @property
    def n_a(self) -> int:
        """Number of motors."""
        return int(self.gains.shape[0])

    @property
    def is_preloaded(self) -> bool:
        """Whether there is an effort on a member where the motors have none."""
        return bool(self.offsets.any())

    @property
    def motors(self) -> Ints:
        """The motor of every member: (members,)."""
        gains = self.gains.tocoo()
        motors = np.zeros(len(self.offsets), dtype=np.int64)
        motors[gains.col] = gains.row
        return motors

    def motors_of(self, members: Ints) -> Ints:
        """The motors (m,) of members (m,); −1 remains −1."""
        motors: Ints = np.append(self.motors, -1)[members]
        return motors

    def rows(self, members: Rows) -> Rows:
        """Rows of the motors (n_a, n) from those of the members."""
        return Rows(self.gains @ members.H, self.gains @ members.delta)

    def efforts(self, lam: Array) -> Array:
        """Efforts on the members (members,) under efforts of the motors lam (n_a,)."""
        efforts: Array = self.offsets + self.gains.T @ lam
        return efforts


def coupling_of(config: RobotConfig) -> Coupling | None:
    """The couplings of a robot file; None where there are none.

    The coordinates of drums are single actuators of their own, after all others, with a gain of one.
    """
    if not config.couplings:
        return None
    number = {item.name: place for place, item in enumerate(config.single_actuators)}
    motors, places, gains = [], [], []
    drums = [item.name for item in config.couplings if item.kind == "drum"]
    count = len(number) + len(drums)
    offsets = np.zeros(count)
    for motor, item in enumerate(config.actuators):
        if isinstance(item, CouplingSettings):
            own = [number[name] for name in item.members]
            if item.kind == "drum":
                # its cables are its own, but it moves them by their springs: gains of zero are stored
                gains += [*[0.0] * len(own), 1.0]
                own.append(len(number) + drums.index(item.name))
            else:
                gains += item.gains
                offsets[own] = item.offsets
        else:
            own = [number[item.name]]
            gains.append(1.0)
        places += own
        motors += [motor] * len(own)
    shape = (len(config.actuators), count)
    return Coupling(sp.csr_array((gains, (motors, places)), shape=shape), offsets)
