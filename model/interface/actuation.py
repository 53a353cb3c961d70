"""What the actuators of a robot are: names, kinds with their units, and the laws that they obey.

An actuator has a position δ and a work-conjugate effort λ, each in the unit of its kind. In the names of
this code the position is `pull` and the effort `tension`, whatever the kind.

A cable obeys 0 ≤ δ − pull ⟂ λ ≥ 0 where its pull is given: it may be slack and never pushes. All others are
bilateral, δ = pull with λ of either sign, and so is a cable whose tension may be negative, a rod.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from functools import cached_property

import numpy as np

from tauten.model.interface.command import Command
from tauten.model.numerics import Array, Bools, Ints
from tauten.model.schema import CableSettings, CouplingSettings, RobotSettings, SingleActuator


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

    @property
    def position(self) -> Quantity:
        """What δ is."""
        return _QUANTITIES[self][0]

    @property
    def effort(self) -> Quantity:
        """What λ is."""
        return _QUANTITIES[self][1]


_QUANTITIES = {
    ActuatorKind.CABLE: (
        Quantity("pull", "m", "mm", 1e3),
        Quantity("tension", "N", "N", 1.0),
    ),
    ActuatorKind.CHAMBER: (
        Quantity("volume change", "m³", "mL", 1e6),
        Quantity("pressure", "Pa", "kPa", 1e-3),
    ),
    ActuatorKind.DRIVE: (
        Quantity("angle", "rad", "deg", 180.0 / np.pi),
        Quantity("torque", "N m", "N mm", 1e3),
    ),
    ActuatorKind.SLIDE: (
        Quantity("travel", "m", "mm", 1e3),
        Quantity("force", "N", "N", 1.0),
    ),
    ActuatorKind.FORCE: (
        Quantity("displacement", "m", "mm", 1e3),
        Quantity("force", "N", "N", 1.0),
    ),
}


@dataclass(frozen=True, slots=True)
class Springs:
    """Springs in series between motors and what they move: δ_motor = δ + flexibility λ + shift.

    Attributes:
        flexibility: (n_a,) inverse stiffness, zero without a spring [m/N].
        shift: (n_a,) position of the motor where δ and λ are zero, negative with pretension [m].
    """

    flexibility: Array
    shift: Array

    def position(self, delta: Array, lam: Array) -> Array:
        """Positions of the motors (n_a,) of positions delta and efforts lam of what they move."""
        position: Array = delta + self.flexibility * lam + self.shift
        return position

    def effort(self, position: Array, delta: Array) -> Array:
        """Efforts (n_a,) of the springs between motors at `position` and what they move, at `delta`."""
        stretch = position - delta - self.shift
        return np.divide(
            stretch, self.flexibility, out=np.zeros_like(stretch), where=self.flexibility > 0.0
        )


@dataclass(frozen=True, eq=False)
class Actuators:
    """The actuators of a robot in the order of λ_a.

    Attributes:
        names: in keys, messages and tables.
        kinds: of each.
        bilateral: (n_a,) whether δ = pull holds where the pull is given, with an effort of either sign.
        held_by_force: (n_a,) whether a hold keeps λ rather than δ.
        springs: between motors and what they move; None: there are none.
    """

    names: tuple[str, ...]
    kinds: tuple[ActuatorKind, ...]
    bilateral: Bools
    held_by_force: Bools
    springs: Springs | None = None

    def __len__(self) -> int:
        return len(self.names)

    def at(self, chosen: Ints) -> Actuators:
        """Names and laws of some of them, by their numbers (c,), without springs."""
        return Actuators(
            tuple(self.names[i] for i in chosen.tolist()),
            tuple(self.kinds[i] for i in chosen.tolist()),
            self.bilateral[chosen],
            self.held_by_force[chosen],
        )

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

    def held(self, pull: Array, tension: Array) -> Command:
        """What a hold keeps of positions and efforts (n_a,).

        Args:
            pull: positions that left last.
            tension: efforts that left last.
        """
        by_force = self.held_by_force
        return Command(np.where(by_force, np.nan, pull), np.where(by_force, tension, np.nan))


def cable_actuators(names: tuple[str, ...]) -> Actuators:
    """Actuators that are all cables, held at their pulled lengths."""
    none = np.zeros(len(names), dtype=np.bool_)
    return Actuators(names, (ActuatorKind.CABLE,) * len(names), none, none)


def actuators_of(config: RobotSettings) -> Actuators:
    """The actuators of a robot file."""
    motors = [_motor(item, config) for item in config.actuators]
    springs = Springs(
        np.array([motor.flexibility for motor in motors]),
        np.array([motor.shift for motor in motors]),
    )
    return Actuators(
        names=tuple(item.name for item in config.actuators),
        kinds=tuple(motor.kind for motor in motors),
        bilateral=np.array([motor.bilateral for motor in motors], np.bool_),
        held_by_force=np.array([item.held == "force" for item in config.actuators], np.bool_),
        springs=springs if springs.flexibility.any() else None,
    )


@dataclass(frozen=True, slots=True)
class _Motor:
    """Kind and law of one actuator; attributes as in `Actuators` and `Springs`."""

    kind: ActuatorKind
    bilateral: bool
    flexibility: float
    shift: float


def _motor(item: SingleActuator | CouplingSettings, config: RobotSettings) -> _Motor:
    """Kind and law of an actuator or a coupling of a robot file."""
    if not isinstance(item, CouplingSettings):
        members: list[SingleActuator] = [item]
        gains, offsets = [1.0], [0.0]
    else:
        single = {found.name: found for found in config.single_actuators}
        members = [single[name] for name in item.members]
        gains, offsets = item.gains, item.offsets
    kind, flexibility, shift = ActuatorKind(members[0].kind), 0.0, 0.0
    if (
        isinstance(item, CouplingSettings) and item.kind == "drum"
    ):  # springs between it and its cables
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
