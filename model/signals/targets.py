"""Targets of effectors: what a user may give, and its values in a row."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from tauten.model.numerics import Array
from tauten.model.schema import COMPONENTS, EffectorKind, shown

VALUES: dict[EffectorKind, int] = COMPONENTS | {"frame": 7}
_GOALS = {1: "a number", 3: "a position", 7: "a Pose"}  # by the number of values


@dataclass(frozen=True, slots=True)
class Pose:
    """Goal of a frame.

    Attributes:
        position: (3,) [m].
        quaternion: (4,) unit quaternion (w, x, y, z); its negative is the same rotation.
    """

    position: tuple[float, float, float]
    quaternion: tuple[float, float, float, float]


EffectorGoal: TypeAlias = "Pose | float | Sequence[float] | Array"  # of one effector, by its kind
# Of all effectors; an array (p, 3) where all are points or centres; of one effector alone its goal.
Target: TypeAlias = "EffectorGoal | Sequence[EffectorGoal]"


def target_values(target: Target, names: tuple[str, ...], kinds: tuple[EffectorKind, ...]) -> Array:
    """A target as goal values (n_v,), those of all effectors in a row.

    Args:
        target: (n_v,) values; (p, 3) positions where all effectors are points or centres; or one goal
            for each effector, by its kind a position (3,), a `Pose` or a number. Of a single effector
            its goal alone.
        names: of the effectors.
        kinds: of the effectors.

    Raises:
        ValueError: it has another shape, or entries that are no numbers.
    """
    given = [target] if isinstance(target, Pose | float | int) else target
    sizes = list(map(VALUES.__getitem__, kinds))
    try:
        values = np.asarray(given)
        values = values.astype(np.float64, copy=False) if values.dtype.kind != "c" else _real(given)
    except (TypeError, ValueError, OverflowError):  # poses, or goals of several lengths
        values = _joined(given, sizes) if isinstance(given, Sequence) else np.zeros(0)
    if values.shape == (sum(sizes),):
        return values
    if values.shape == (len(names), 3) and set(sizes) == {3}:
        return values.ravel()
    raise ValueError(f"target: found {_shape_of(target)}, expected {_expected(names, kinds)}")


def _joined(target: Sequence[EffectorGoal] | Sequence[float], sizes: list[int]) -> Array:
    """One goal for each effector as values (n_v,); empty where they have other numbers of values."""
    try:
        parts = [_flat(goal) for goal in target]
    except (TypeError, ValueError, OverflowError):
        return np.zeros(0)
    return np.concatenate(parts) if [len(part) for part in parts] == sizes else np.zeros(0)


def _real(given: object) -> Array:
    """An array of real numbers; a TypeError for complex ones, whose imaginary parts NumPy would leave out."""
    values = np.asarray(given)
    if values.dtype.kind == "c":
        raise TypeError(f"complex numbers of shape {values.shape}")
    return values.astype(np.float64, copy=False)


def _flat(goal: EffectorGoal) -> Array:
    """A goal of one effector as its values."""
    if isinstance(goal, Pose):
        return np.concatenate([_real(goal.position), _real(goal.quaternion)])
    return np.atleast_1d(_real(goal)).ravel()


def _shape_of(target: object) -> str:
    """The shape of a target, or what it is where it has none, for errors."""
    try:
        return f"shape {_real(target).shape}"
    except (TypeError, ValueError, OverflowError):
        return shown(target)


def _expected(names: tuple[str, ...], kinds: tuple[EffectorKind, ...]) -> str:
    """What a target is, for errors."""
    sizes = [VALUES[kind] for kind in kinds]
    if set(sizes) == {3}:
        if len(names) == 1:
            return f"shape (3,), the position of {names[0]} [m]"
        return f"shape ({len(names)}, 3), the positions of {', '.join(names)} [m]"
    goals = [f"{_GOALS[size]} for {name}" for name, size in zip(names, sizes, strict=True)]
    return f"{', '.join(goals)}, or shape ({sum(sizes)},), all values in a row"
