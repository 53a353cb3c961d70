"""Ranges of plots: wide enough that noise stays small, and steady while values stay within them."""

from __future__ import annotations

import numpy as np

from tauten.model.numerics import Array

_ROOM = 0.08  # of the range, above and below the values
_TIGHT = 0.3  # of a range, which is made smaller where the values need less


def padded_range(
    values: Array, least: float, before: tuple[float, float] | None
) -> tuple[float, float]:
    """A range around values.

    Args:
        values: that are drawn, finite ones among them.
        least: its least width.
        before: the range so far, which stays where the values are within it and take much of it.
    """
    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 0.0)
    if before is not None and before[0] <= low and high <= before[1]:
        width = before[1] - before[0]
        if width <= max(least, (high - low) / _TIGHT) * (1.0 + 1e-9):
            return before
    width = max(least, (high - low) * (1.0 + 2.0 * _ROOM))
    middle = 0.5 * (low + high)
    return middle - 0.5 * width, middle + 0.5 * width
