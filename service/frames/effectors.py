"""Effectors as a viewer knows them: kind, goal values at rest, and where they are among all goal values."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model import VALUES
from tauten.model.numerics import Array
from tauten.model.schema import EffectorKind


@dataclass(frozen=True, slots=True)
class EffectorLook:
    """One effector.

    Attributes:
        name: of the effector.
        kind: of the effector, see `EffectorLayout`.
        rest: (v,) its goal values at rest.
        first: number of its first value among those of all effectors.
    """

    name: str
    kind: EffectorKind
    rest: tuple[float, ...]
    first: int

    @property
    def has_position(self) -> bool:
        """Whether its values begin with a position; distances, lengths and volumes are one number."""
        return len(self.rest) >= 3

    @property
    def turns(self) -> bool:
        """Whether its values end with a quaternion."""
        return self.kind == "frame"

    @property
    def places(self) -> slice:
        """Its values among those of all effectors."""
        return slice(self.first, self.first + len(self.rest))


def effector_looks(
    names: tuple[str, ...], kinds: tuple[EffectorKind, ...], rest: list[tuple[float, ...]]
) -> tuple[EffectorLook, ...]:
    """Effectors in their order.

    Args:
        names: of the effectors.
        kinds: of the effectors.
        rest: goal values of each at rest.

    Raises:
        ValueError: an effector with as many values as its kind does not have.
    """
    found, first = [], 0
    for name, kind, values in zip(names, kinds, rest, strict=True):
        if len(values) != VALUES[kind]:
            raise ValueError(f"effector {name!r} of kind {kind!r} with {len(values)} values")
        found.append(EffectorLook(name, kind, values, first))
        first += len(values)
    return tuple(found)


def positions_of(effectors: tuple[EffectorLook, ...], values: Array) -> Array:
    """Positions (p, 3) [m] among goal values (n_v,); NaN for effectors without one."""
    found = np.full((len(effectors), 3), np.nan)
    for i, effector in enumerate(effectors):
        if effector.has_position:
            found[i] = values[effector.first : effector.first + 3]
    return found


def distance_between(effectors: tuple[EffectorLook, ...], goal: Array, values: Array) -> float:
    """Largest distance [m] of effectors from their goals, without volumes and rotations; NaN without any.

    Args:
        effectors: of the robot.
        goal: (n_v,) goal values that are wanted.
        values: (n_v,) goal values that are.
    """
    found = [
        float(np.linalg.norm((goal - values)[effector.places][:3]))
        for effector in effectors
        if effector.kind != "volume"
    ]
    finite = [distance for distance in found if distance == distance]
    return max(finite, default=float("nan"))
