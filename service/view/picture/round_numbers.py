"""Numbers that are easy to read: 1, 2 and 5 times powers of ten."""

from __future__ import annotations

import numpy as np

_DIGITS = (1.0, 2.0, 5.0, 10.0)
_ROUNDING = 1e-9  # relative; a number that is round itself stays


def rounded_up(value: float) -> float:
    """The least round number that is not below a positive value."""
    return next(one for one in _near(value) if one >= value * (1.0 - _ROUNDING))


def rounded_down(value: float) -> float:
    """The largest round number that is not above a positive value."""
    return max(one for one in _near(value) if one <= value * (1.0 + _ROUNDING))


def _near(value: float) -> list[float]:
    """Round numbers around a value, ascending."""
    power = 10.0 ** np.floor(np.log10(max(value, 1e-12)))
    return [float(one * power) for one in _DIGITS]
