"""Regions of space that robot files name."""

from __future__ import annotations

import numpy as np

from tauten.model.numerics import Array, Bools
from tauten.model.schema import Box


def in_box(points: Array, box: Box) -> Bools:
    """Which points (m, 3) lie in the box, its faces included: (m,) bool.

    The box is exact: choose it slightly larger where node positions are rounded.
    """
    inside: Bools = np.all((points >= box.lower) & (points <= box.upper), axis=1)
    return inside
