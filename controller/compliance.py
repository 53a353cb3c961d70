"""Response of effectors, cables and contacts to forces on each other, (11)-(12)."""

from __future__ import annotations

from dataclasses import dataclass

from tauten.model.numerics import Array


@dataclass(frozen=True, slots=True)
class Response:
    """δ = δ_free + W λ, rows in the order effectors, actuators, contacts (m = n_e + n_a + n_c).

    Attributes:
        W: (m, m) compliance [m/N], symmetric positive semidefinite.
        delta_free: (m,) row values after a step without forces [m]: effector positions, pulled
            lengths, gaps.
        n_e: effector rows.
        n_a: actuator rows.
        n_c: contact rows, after reduction.
    """

    W: Array
    delta_free: Array
    n_e: int
    n_a: int
    n_c: int
