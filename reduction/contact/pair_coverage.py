"""Coverage of a basis: candidates with force in a mode, and those where contact would be missed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model import Robot
from tauten.model.numerics import Ints
from tauten.reduction.contact.basis import ContactBasis


@dataclass(frozen=True, slots=True, eq=False)
class PairCoverage:
    """Coverage of one contact pair.

    Attributes:
        pair: its name.
        slots: (m,) slots of its candidates.
        untouched: (u,) those without force in any mode: contact there needs extra columns.
        modes: (j,) modes with forces on the pair.
    """

    pair: str
    slots: Ints
    untouched: Ints
    modes: Ints


def coverage(robot: Robot, basis: ContactBasis) -> tuple[PairCoverage, ...]:
    """Coverage of every contact pair of the robot that the basis was made for.

    Raises:
        BasisError: it was made for another robot.
    """
    basis.check_robot(robot)
    result = []
    for pair in robot.pairs:
        slots = np.arange(pair.first, pair.end)
        weights = basis.Psi[slots]  # (m, k)
        untouched = slots[~weights.any(axis=1)]
        result.append(
            PairCoverage(pair.name, slots, untouched, np.flatnonzero(weights.any(axis=0)))
        )
    return tuple(result)
