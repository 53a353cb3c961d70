"""Directions of the picture: up is against gravity."""

from __future__ import annotations

import numpy as np

from tauten.model.numerics import Array

WEIGHTLESS = 1e-6  # m/s²


def upwards(gravity: tuple[float, float, float]) -> tuple[float, float, float]:
    """The direction against gravity; without gravity that of z."""
    size = float(np.linalg.norm(gravity))
    if size < WEIGHTLESS:
        return (0.0, 0.0, 1.0)
    x, y, z = (-float(part) / size for part in gravity)
    return x, y, z


def sideways(up: Array) -> tuple[Array, Array]:
    """Unit vectors to the right and away from somebody who looks at the robot from the front.

    Where the unit vector upwards (3,) is that of z they are those of x and y.
    """
    x = np.eye(3)[0] if abs(up[0]) < 0.9 else np.eye(3)[1]
    right: Array = x - (x @ up) * up
    right /= np.linalg.norm(right)
    return right, np.cross(up, right)
