"""The motors of a robot of parts: each actuator of a part by itself, or several of them by one motor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from tauten.model.actuators import Coupling
from tauten.model.numerics import Array
from tauten.model.parts.part import Part
from tauten.model.schema import CouplingSettings
from tauten.model.signals import Actuators, Laws, Limits, Springs, joined_limits


@dataclass(frozen=True, slots=True, eq=False)
class Motors:
    """The motors of a robot of parts.

    Attributes:
        actuators: names, kinds and laws.
        limits: of each motor, and of the efforts of what it drives.
        coupling: of the actuators of all parts; None: each is a motor of its own.
    """

    actuators: Actuators
    limits: Limits
    coupling: Coupling | None


def parts_motors(parts: Sequence[Part], couplings: Sequence[CouplingSettings]) -> Motors:
    """The actuators of all parts, part by part; a motor of several stands where its first one stood.

    Args:
        parts: the parts.
        couplings: differentials without pretensions, over the names that actuators have in the robot.

    Raises:
        ValueError: a member that is unknown, of another motor, or of another kind than the others; limits of
            members that leave the motor no effort.
    """
    robots = [part.robot for part in parts]
    single = Actuators(
        names=tuple(part.named(name) for part in parts for name in part.robot.actuators.names),
        kinds=tuple(kind for robot in robots for kind in robot.actuators.kinds),
        laws=Laws.joined([robot.actuators.laws for robot in robots]),
    )
    limits = joined_limits([robot.limits for robot in robots])
    if not couplings:
        return Motors(single, limits, None)
    items = motors_by_place(single, couplings)
    gains = np.zeros((len(items), len(single)))
    for row, (k, item) in zip(gains, items.items(), strict=True):
        row[k] = 1.0
        if item is not None:
            row[[single.names.index(name) for name in item.members]] = item.gains
    springs = single.laws.springs or Springs.none(len(single))
    laws = Laws(
        bilateral=((gains != 0.0) & (single.laws.bilateral | (gains < 0.0))).any(axis=1),
        held_by_force=np.array(
            [
                single.laws.held_by_force[k] if item is None else item.held == "force"
                for k, item in items.items()
            ]
        ),
        springs=Springs(gains**2 @ springs.flexibility, gains @ springs.shift)
        if springs.flexibility.any()
        else None,
    )
    actuators = Actuators(
        names=tuple(single.names[k] if item is None else item.name for k, item in items.items()),
        kinds=tuple(single.kinds[k] for k in items),
        laws=laws,
    )
    ranges = [
        motor_range(row, item, limits) for row, item in zip(gains, items.values(), strict=True)
    ]
    coupling = Coupling(sp.csr_array(gains), np.zeros(len(single)))
    return Motors(actuators, Limits(*np.array(ranges).T), coupling)


def motors_by_place(
    single: Actuators, couplings: Sequence[CouplingSettings]
) -> dict[int, CouplingSettings | None]:
    """The motors in order, each by the number of its first actuator; None: that is a motor of its own.

    Args:
        single: the actuators of all parts.
        couplings: as of `parts_motors`.

    Raises:
        ValueError: see `parts_motors`.
    """
    found: dict[int, CouplingSettings | None] = dict.fromkeys(range(len(single)))
    taken: set[str] = set()
    for index, item in enumerate(couplings):
        for name in item.members:
            if name not in single.names:
                raise ValueError(
                    f"couplings.{index}: member {name!r} is not defined, known are {', '.join(single.names)}"
                )
            if name in taken:
                raise ValueError(f"couplings.{index}: member {name!r} has another motor already")
            taken.add(name)
        members = [single.names.index(name) for name in item.members]
        kinds = {single.kinds[k].value for k in members}
        if len(kinds) > 1:
            raise ValueError(
                f"couplings.{index}: members must be of one kind, found {', '.join(sorted(kinds))}"
            )
        found[min(members)] = item
        for k in members:
            if k != min(members):
                del found[k]
    return found


def motor_range(
    gains: Array, item: CouplingSettings | None, limits: Limits
) -> tuple[float, float, float, float, float]:
    """Limits of a motor as in `Limits`: its own, and the efforts that every member allows.

    Args:
        gains: (members,) of all actuators.
        item: the motor; None: the actuator drives itself.
        limits: of all actuators.

    Raises:
        ValueError: they leave no effort.
    """
    members = np.flatnonzero(gains)
    if item is None:
        own = limits.at(members)
        return (
            float(own.effort_min[0]), float(own.effort_max[0]), float(own.position_min[0]),
            float(own.position_max[0]), float(own.rate[0]),
        )  # fmt: skip
    gain = gains[members]
    ends = np.sort([limits.effort_min[members] / gain, limits.effort_max[members] / gain], axis=0)
    motor = item.limits
    least = max(motor.least_effort, float(ends[0].max()))
    most = min(motor.most_effort, float(ends[1].min()))
    if not least <= 0.0 <= most or least == most:
        raise ValueError(
            f"couplings.{item.name}: the limits of its members allow efforts of the motor from {least:g} to "
            f"{most:g}; zero, the value at rest, must be between them"
        )
    return least, most, motor.least_position, motor.most_position, motor.rate
