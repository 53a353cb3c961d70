"""Arguments that a caller gives, checked: one sentence for what is of another kind."""

from __future__ import annotations

import operator
from typing import TypeVar

import numpy as np

T = TypeVar("T")


def of_kind(name: str, given: object, kind: type[T]) -> T:
    """An argument of that name that has to be of a kind.

    Raises:
        TypeError: it is of another kind.
    """
    if isinstance(given, kind):
        return given
    raise TypeError(f"{name}: expected {kind.__name__}, found {type(given).__name__}")


def count(name: str, given: object) -> int:
    """An argument that has to be a whole number of at least 1, or a ValueError that names it."""
    try:
        found = operator.index(given)  # type: ignore[arg-type]
    except TypeError:
        found = 0
    if found < 1:
        raise ValueError(f"{name}: found {given!r}, expected a whole number of at least 1")
    return found


def positive(name: str, given: object) -> float:
    """An argument that has to be a positive number, or a ValueError that names it."""
    if not isinstance(given, int | float | np.number) or not 0.0 < given < np.inf:
        raise ValueError(f"{name}: found {given}, expected a positive number")
    return float(given)
