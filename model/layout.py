"""Where the rows of effectors, actuators and contacts are in a step."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache


@dataclass(frozen=True, slots=True)
class Layout:
    """Places of effectors, actuators and contacts among the rows of a step, in this order.

    An effector's own rows are among `effectors` where `EffectorLayout.rows_of` says; an actuator has one.

    Attributes:
        effectors: their rows; none where a step leaves them out.
        actuators: their rows.
        contacts: rows of the reduced contacts, then of the unit columns, to the last one.
        acting: rows that have forces: actuators and contacts.
        n_e: effector rows.
        n_a: actuators.
    """

    effectors: slice
    actuators: slice
    contacts: slice
    acting: slice
    n_e: int
    n_a: int


@lru_cache(maxsize=64)
def row_layout(n_e: int, n_a: int) -> Layout:
    """The layout of n_e effector rows and n_a actuators."""
    first = n_e + n_a
    return Layout(slice(0, n_e), slice(n_e, first), slice(first, None), slice(n_e, None), n_e, n_a)
