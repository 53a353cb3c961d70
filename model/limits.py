"""What the winches can do: tension, pulled length, rate."""

from __future__ import annotations

from dataclasses import dataclass

from tauten.model.arrays import Array


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
