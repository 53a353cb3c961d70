"""Effectors as a viewer knows them: kind, goal values at rest, and where they are among all goal values."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model import ROWS, VALUES
from tauten.model.numerics import Array, Bools
from tauten.model.schema import EffectorKind


@dataclass(frozen=True, slots=True)
class EffectorLook:
    """One effector.

    Attributes:
        name: of the effector.
        kind: of the effector, see `EffectorLayout`.
        rest: (v,) its goal values at rest.
        first: number of its first value among those of all effectors.
        weights: (c,) of its components in the objective, 0 where one is left free; None: all count.
    """

    name: str
    kind: EffectorKind
    rest: tuple[float, ...]
    first: int
    weights: tuple[float, ...] | None = None

    @property
    def has_position(self) -> bool:
        """Whether its values begin with a position; distances, lengths and volumes are one number."""
        return len(self.rest) >= 3

    @property
    def turns(self) -> bool:
        """Whether its values end with a quaternion."""
        return self.kind == "frame"

    @property
    def wanted(self) -> Bools:
        """(3,) which coordinates of its position have a goal, (1,) for one number."""
        count = min(len(self.rest), 3)
        weights = (1.0,) * count if self.weights is None else self.weights[:count]
        wanted: Bools = np.array(weights) > 0.0
        return wanted

    @property
    def places(self) -> slice:
        """Its values among those of all effectors."""
        return slice(self.first, self.first + len(self.rest))


def effector_looks(
    names: tuple[str, ...],
    kinds: tuple[EffectorKind, ...],
    rest: list[tuple[float, ...]],
    weights: list[tuple[float, ...]] | None = None,
) -> tuple[EffectorLook, ...]:
    """Effectors in their order.

    Args:
        names: of the effectors.
        kinds: of the effectors.
        rest: goal values of each at rest.
        weights: of the components of each; None: all count.

    Raises:
        ValueError: an effector with as many values or weights as its kind does not have.
    """
    found, first = [], 0
    for i, (name, kind, values) in enumerate(zip(names, kinds, rest, strict=True)):
        own = None if weights is None else weights[i]
        if len(values) != VALUES[kind]:
            raise ValueError(f"effector {name!r} of kind {kind!r} with {len(values)} values")
        if own is not None and len(own) != ROWS[kind]:
            raise ValueError(f"effector {name!r} of kind {kind!r} with {len(own)} weights")
        found.append(EffectorLook(name, kind, values, first, own))
        first += len(values)
    return tuple(found)


def positions_of(effectors: tuple[EffectorLook, ...], values: Array) -> Array:
    """Positions (p, 3) [m] among goal values (n_v,); NaN for effectors without one."""
    found = np.full((len(effectors), 3), np.nan)
    for i, effector in enumerate(effectors):
        if effector.has_position:
            found[i] = values[effector.first : effector.first + 3]
    return found


def targets_of(effectors: tuple[EffectorLook, ...], goal: Array, values: Array) -> Array:
    """Where targets are shown: (p, 3) [m]; coordinates that are left free are those of the effector.

    Args:
        effectors: of the robot.
        goal: (n_v,) goal values that are wanted.
        values: (n_v,) goal values that are.
    """
    targets, now = positions_of(effectors, goal), positions_of(effectors, values)
    for i, effector in enumerate(effectors):
        if effector.has_position and np.isfinite(targets[i][effector.wanted]).all():
            targets[i] = np.where(effector.wanted, targets[i], now[i])
            if not effector.wanted.any():
                targets[i] = np.nan
    return targets


def distance_between(effectors: tuple[EffectorLook, ...], goal: Array, values: Array) -> float:
    """Largest distance [m] of effectors from their goals; NaN without any.

    Without volumes, rotations and components that are left free.

    Args:
        effectors: of the robot.
        goal: (n_v,) goal values that are wanted.
        values: (n_v,) goal values that are.
    """
    found = [
        float(np.linalg.norm((goal - values)[effector.places][:3][effector.wanted]))
        for effector in effectors
        if effector.kind != "volume" and effector.wanted.any()
    ]
    finite = [distance for distance in found if distance == distance]
    return max(finite, default=float("nan"))
