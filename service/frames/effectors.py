"""Goal values of several effectors, as a viewer shows them: positions, targets, distances."""

from __future__ import annotations

import numpy as np

from tauten.model.numerics import Array
from tauten.service.wire import DescribedEffector, places_of


def positions_of(effectors: tuple[DescribedEffector, ...], values: Array) -> Array:
    """Positions (p, 3) [m] among goal values (n_v,); NaN for effectors without one."""
    found = np.full((len(effectors), 3), np.nan)
    for i, (effector, place) in enumerate(zip(effectors, places_of(effectors), strict=True)):
        if effector.has_position:
            found[i] = values[place][:3]
    return found


def targets_of(effectors: tuple[DescribedEffector, ...], goal: Array, values: Array) -> Array:
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


def distance_between(effectors: tuple[DescribedEffector, ...], goal: Array, values: Array) -> float:
    """Largest distance [m] of effectors from their goals; NaN without any.

    Without volumes, rotations and components that are left free.

    Args:
        effectors: of the robot.
        goal: (n_v,) goal values that are wanted.
        values: (n_v,) goal values that are.
    """
    found = [
        float(np.linalg.norm((goal - values)[place][:3][effector.wanted]))
        for effector, place in zip(effectors, places_of(effectors), strict=True)
        if effector.kind != "volume" and effector.wanted.any()
    ]
    finite = [distance for distance in found if distance == distance]
    return max(finite, default=float("nan"))
