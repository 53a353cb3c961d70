"""The motors of a robot of parts: each actuator of a part by itself, or several of them by one motor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from tauten.model.actuators import Coupling
from tauten.model.parts.part import Part
from tauten.model.schema import CouplingSettings, Range
from tauten.model.signals import Actuators, Laws, Limits, Springs, allowed_efforts, joined_limits


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
        limits.range_of(k) if item is None else motor_range(single, limits, item)
        for k, item in items.items()
    ]
    coupling = Coupling(sp.csr_array(gains), np.zeros(len(single)))
    return Motors(actuators, Limits.of(ranges), coupling)


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


def motor_range(single: Actuators, limits: Limits, item: CouplingSettings) -> Range:
    """Limits of a motor of several actuators: its own, and the efforts that every member allows.

    Args:
        single: the actuators of all parts.
        limits: of these.
        item: the motor.

    Raises:
        ValueError: they leave no effort.
    """
    members = [limits.range_of(single.names.index(name)) for name in item.members]
    own, (least, most) = item.limits, allowed_efforts(item, members)
    if not least <= 0.0 <= most or least == most:
        raise ValueError(
            f"couplings.{item.name}: the limits of its members allow efforts of the motor from {least:g} to "
            f"{most:g}; zero, the value at rest, must be between them"
        )
    return Range(least, most, own.least_position, own.most_position, own.rate)
