"""Spaces of contact forces: λ_c = Ψ β.

A space turns the pointwise contact rows in range into as many rows as it has columns in play. The
bases of `tauten.reduction` are one kind; here are the protocol and the empty one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from tauten.model.numerics import Array, Ints
from tauten.model.rows import ContactRows


@dataclass(frozen=True, slots=True)
class ReducedContacts:
    """Contact rows seen through a space of contact forces (18)-(19).

    Attributes:
        H: (k', n) dense, Ψᵀ H_c.
        delta: (k',) Ψᵀ δ_c [m].
        modes: (k',) which columns of the space these are.
    """

    H: Array
    delta: Array
    modes: Ints

    def __len__(self) -> int:
        return len(self.delta)


@runtime_checkable
class ContactSpace(Protocol):
    """Non-negative columns that contact forces are combined from."""

    @property
    def k(self) -> int:
        """Number of columns."""

    def reduce(self, contacts: ContactRows) -> ReducedContacts:
        """Rows of the columns that have a candidate in range; pairs with friction are left out."""

    def lift(self, beta: Array) -> Array:
        """Pointwise forces λ_c (n_c,) of coefficients beta (k,) [N]."""


@dataclass(frozen=True, slots=True)
class EmptySpace:
    """No columns: no contact, or contact carried by unit columns alone.

    Attributes:
        n_slots: n_c.
    """

    n_slots: int

    k = 0

    def reduce(self, contacts: ContactRows) -> ReducedContacts:
        """No rows."""
        return ReducedContacts(
            np.zeros((0, contacts.rows.n)), np.zeros(0), np.zeros(0, dtype=np.int64)
        )

    def lift(self, beta: Array) -> Array:
        """No forces: zeros (n_c,)."""
        return np.zeros(self.n_slots)
