"""What the actuators of a robot are: names, kinds with their units, and the laws that they obey.

An actuator has a position δ and a work-conjugate effort λ, each in the unit of its kind: pulled length and
tension of a cable, change of volume and pressure of a chamber.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from functools import cached_property

import numpy as np

from tauten.model.numerics import Bools, Ints
from tauten.model.schema import CableSettings, CouplingSettings, RobotConfig, SingleActuator
from tauten.model.signals.laws import Laws, Springs


@dataclass(frozen=True, slots=True)
class Quantity:
    """A quantity of an actuator.

    Attributes:
        name: in messages.
        unit: SI unit.
        shown_unit: unit in tables and plots.
        scale: from the SI unit to the one shown.
    """

    name: str
    unit: str
    shown_unit: str
    scale: float

    @property
    def label(self) -> str:
        """Name and unit for an axis or the head of a column."""
        return f"{self.name} [{self.shown_unit}]"

    def text(self, value: float) -> str:
        """A value in SI units, with the unit it is shown in."""
        return f"{self.scale * value:.3g} {self.shown_unit}"


class ActuatorKind(Enum):
    """Kinds of actuators; the value is the name in messages."""

    CABLE = "cable"
    CHAMBER = "chamber"
    DRIVE = "drive"
    SLIDE = "slide"
    FORCE = "force"
    TRANSMISSION = "transmission"
    ROTARY_TRANSMISSION = "rotary transmission"
    FLUID_TRANSMISSION = "fluid transmission"

    @property
    def position(self) -> Quantity:
        """What δ is."""
        return _QUANTITIES[self][0]

    @property
    def effort(self) -> Quantity:
        """What λ is."""
        return _QUANTITIES[self][1]


_PULL = Quantity("pull", "m", "mm", 1e3), Quantity("tension", "N", "N", 1.0)
_FLUID = Quantity("volume change", "m³", "mL", 1e6), Quantity("pressure", "Pa", "kPa", 1e-3)
_TURN = Quantity("angle", "rad", "deg", 180.0 / np.pi), Quantity("torque", "N m", "N mm", 1e3)
_FORCE = Quantity("force", "N", "N", 1.0)
_QUANTITIES = {
    ActuatorKind.CABLE: _PULL,
    ActuatorKind.CHAMBER: _FLUID,
    ActuatorKind.DRIVE: _TURN,
    ActuatorKind.SLIDE: (Quantity("travel", "m", "mm", 1e3), _FORCE),
    ActuatorKind.FORCE: (Quantity("displacement", "m", "mm", 1e3), _FORCE),
    ActuatorKind.TRANSMISSION: (Quantity("position", "m", "mm", 1e3), _FORCE),
    ActuatorKind.ROTARY_TRANSMISSION: _TURN,
    ActuatorKind.FLUID_TRANSMISSION: _FLUID,
}


@dataclass(frozen=True, eq=False)
class Actuators:
    """The actuators of a robot in the order of λ_a.

    Attributes:
        names: in keys, messages and tables.
        kinds: of each.
        laws: that they obey.
    """

    names: tuple[str, ...]
    kinds: tuple[ActuatorKind, ...]
    laws: Laws

    def __len__(self) -> int:
        return len(self.names)

    def at(self, chosen: Ints) -> Actuators:
        """Names and laws of some of them, by their numbers (c,), without springs."""
        return Actuators(
            tuple(self.names[i] for i in chosen.tolist()),
            tuple(self.kinds[i] for i in chosen.tolist()),
            self.laws.at(chosen),
        )

    @cached_property
    def are_forces(self) -> Bools:
        """Which are forces of fixed direction: (n_a,)."""
        return np.array([kind is ActuatorKind.FORCE for kind in self.kinds], dtype=np.bool_)

    @cached_property
    def groups(self) -> Ints:
        """Number of the kind of each actuator: (n_a,) int; efforts of one group have one unit."""
        order = list(dict.fromkeys(self.kinds))
        return np.array([order.index(kind) for kind in self.kinds], dtype=np.int64)

    @cached_property
    def position_groups(self) -> Ints:
        """Number of the unit of each position: (n_a,) int, 0 for metres."""
        order = list(dict.fromkeys(("m", *(kind.position.unit for kind in self.kinds))))
        return np.array([order.index(kind.position.unit) for kind in self.kinds], dtype=np.int64)

    @cached_property
    def labels(self) -> tuple[str, ...]:
        """Kind and name of each, for messages."""
        return tuple(
            f"{kind.value} {name}" for kind, name in zip(self.kinds, self.names, strict=True)
        )

    @cached_property
    def effort_names(self) -> tuple[str, ...]:
        """What the limits of the effort are called in messages."""
        pairs = zip(self.kinds, self.labels, strict=True)
        return tuple(f"{kind.effort.name} of {label}" for kind, label in pairs)

    @cached_property
    def position_names(self) -> tuple[tuple[str, str, str], ...]:
        """What the least and the largest position and the rate of each are called in messages."""
        pairs = zip(self.kinds, self.labels, strict=True)
        return tuple(
            (
                f"least {kind.position.name} of {label}",
                f"largest {kind.position.name} of {label}",
                f"rate of {label}",
            )
            for kind, label in pairs
        )


def cable_actuators(names: tuple[str, ...]) -> Actuators:
    """Actuators that are all cables, held at their pulled lengths."""
    none = np.zeros(len(names), dtype=np.bool_)
    return Actuators(names, (ActuatorKind.CABLE,) * len(names), Laws(none, none))


def actuators_of(config: RobotConfig) -> Actuators:
    """The actuators of a robot file."""
    motors = [_motor(item, config) for item in config.actuators]
    springs = Springs(
        np.array([motor.flexibility for motor in motors]),
        np.array([motor.shift for motor in motors]),
    )
    return Actuators(
        names=tuple(item.name for item in config.actuators),
        kinds=tuple(motor.kind for motor in motors),
        laws=Laws(
            bilateral=np.array([motor.bilateral for motor in motors], np.bool_),
            held_by_force=np.array([item.held == "force" for item in config.actuators], np.bool_),
            springs=springs if springs.flexibility.any() else None,
        ),
    )


@dataclass(frozen=True, slots=True)
class _Motor:
    """Kind and law of one actuator; attributes as in `Actuators`, `Laws` and `Springs`."""

    kind: ActuatorKind
    bilateral: bool
    flexibility: float
    shift: float


def _motor(item: SingleActuator | CouplingSettings, config: RobotConfig) -> _Motor:
    """Kind and law of an actuator or a coupling of a robot file."""
    if not isinstance(item, CouplingSettings):
        members: list[SingleActuator] = [item]
        gains, offsets = [1.0], [0.0]
    else:
        single = {found.name: found for found in config.single_actuators}
        members = [single[name] for name in item.members]
        gains, offsets = item.gains, item.offsets
    kind, flexibility, shift = ActuatorKind(members[0].kind), 0.0, 0.0
    # Springs are between a drum and its cables.
    if isinstance(item, CouplingSettings) and item.kind == "drum":
        return _Motor(kind, True, flexibility, shift)
    for member, gain, offset in zip(members, gains, offsets, strict=True):
        if isinstance(member, CableSettings) and member.spring is not None:
            spring = member.spring
            flexibility += gain * gain / spring.stiffness
            shift += gain * (offset - spring.pretension) / spring.stiffness
    pulls_only = (
        min(gains) > 0.0
        and not any(offsets)
        and all(member.limits.least_effort >= 0.0 for member in members)
    )
    return _Motor(kind, kind is not ActuatorKind.CABLE or not pulls_only, flexibility, shift)
