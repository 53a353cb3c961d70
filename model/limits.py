"""Limits of the winches: tension, pulled length, rate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.numerics import Array
from tauten.model.schema import CableSettings


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits of the cables, each (n_a,).

    Attributes:
        tension_min: smallest tension [N], at least 0.
        tension_max: largest tension [N].
        pull_min: smallest pulled length [m].
        pull_max: largest pulled length [m].
        rate: largest speed of the pulled length [m/s].
    """

    tension_min: Array
    tension_max: Array
    pull_min: Array
    pull_max: Array
    rate: Array


def limits_of(cables: list[CableSettings]) -> Limits:
    """Limits of the cables of a robot file."""
    return Limits(
        tension_min=np.array([cable.min_tension for cable in cables]),
        tension_max=np.array([cable.max_tension for cable in cables]),
        pull_min=np.array([cable.min_pull for cable in cables]),
        pull_max=np.array([cable.max_pull for cable in cables]),
        rate=np.array([cable.max_rate for cable in cables]),
    )
