"""The motors of a robot of parts: each actuator of a part by itself, or several of them by one motor."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp

from tauten.model.actuators import Coupling
from tauten.model.numerics import joined
from tauten.model.parts.part import Part
from tauten.model.schema import CouplingSettings, check_couplings
from tauten.model.signals import Actuators, Laws, Limits, Springs, coupled_range


def parts_motors(
    parts: Sequence[Part], couplings: Sequence[CouplingSettings]
) -> tuple[Actuators, Limits, Coupling | None]:
    """The actuators of all parts, their limits and their coupling; None: each is a motor of its own.

    They stand part by part; a motor of several stands where its first one stood.

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
    limits = joined([robot.limits for robot in robots])
    if not couplings:
        return single, limits, None
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
        limits.range_of(k)
        if item is None
        else coupled_range(
            item, [limits.range_of(single.names.index(name)) for name in item.members]
        )
        for k, item in items.items()
    ]
    coupling = Coupling(sp.csr_array(gains), np.zeros(len(single)))
    return actuators, Limits.of(ranges), coupling


def motors_by_place(
    single: Actuators, couplings: Sequence[CouplingSettings]
) -> dict[int, CouplingSettings | None]:
    """The motors in order, each by the number of its first actuator; None: that is a motor of its own.

    Raises:
        ValueError: see `parts_motors`.
    """
    kinds = {name: kind.value for name, kind in zip(single.names, single.kinds, strict=True)}
    check_couplings(couplings, kinds, sprung=set())
    driven = {name: item for item in couplings for name in item.members}
    found: dict[int, CouplingSettings | None] = {}
    for place, name in enumerate(single.names):
        item = driven.get(name)
        if item is None or not any(item is one for one in found.values()):
            found[place] = item
    return found
