"""Compliance between rows: change of one row's value per force on another within a step.

W = h² H A⁻¹ Hᵀ,   δ_free = δ + h H v_free,   δ = δ_free + W λ               (11)-(12)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.numerics import Array, HalfSolving, Ints, kernel
from tauten.model.robot import Robot
from tauten.model.signals import Springs
from tauten.model.system import System

EVERY = slice(None)
# Rows from which on their second halves take longer than those of the forces that are tried.
MANY = 16


@dataclass(frozen=True, slots=True)
class Compliance:
    """Rows condensed through the system of one step.

    Attributes:
        H: (m, n) dense rows.
        Y: (m, n) = (A⁻¹ Hᵀ)ᵀ, velocity change per constraint impulse; with `halves` its first half.
        W: (m, m) compliance [m/N].
        delta_free: (m,) row values after a step without constraint forces [m].
        halves: factors that Y is solved by the first half with; None: it is whole.
    """

    H: Array
    Y: Array
    W: Array
    delta_free: Array
    halves: HalfSolving | None = None

    def __len__(self) -> int:
        return len(self.delta_free)

    @property
    def X(self) -> Array:
        """(A⁻¹ Hᵀ)ᵀ (m, n), velocity change per constraint impulse."""
        return self.Y if self.halves is None else self.halves.second_half(self.Y.T).T

    def pushed(self, lam: Array, rows: slice | Ints = EVERY) -> Array:
        """A⁻¹ Hᵀ λ (n,) for forces lam (r,) on some of the rows."""
        change: Array = lam @ self.Y[rows]
        return change if self.halves is None else self.halves.second_half(change)

    def spring(self, springs: Springs, actuators: slice) -> None:
        """Take the rows of actuators from their ends to their motors, before their springs."""
        between = self.W[actuators, actuators]
        between[np.diag_indices(len(between))] += springs.flexibility
        self.delta_free[actuators] += springs.shift


def row_compliance(system: System, H: Array, delta: Array, by_halves: bool = False) -> Compliance:
    """Condense dense rows through one factorised system.

    Args:
        system: of the step.
        H: (m, n) rows.
        delta: (m,) row values [m].
        by_halves: whether many rows are solved for by halves where that is possible, W = h² Yᵀ Y, and by the
            second half only for forces that are found.
    """
    factors = system.factorisation
    if by_halves and len(H) >= MANY and isinstance(factors, HalfSolving):
        return _by_halves(system, H, delta, factors)
    X = np.ascontiguousarray(factors.solve(H.T).T)  # (m, n)
    W, delta_free = np.empty((len(H), len(H))), np.empty(len(H))
    _condense(H, X, delta, (system.h, system.v_free), W, delta_free)
    return Compliance(H, X, W, delta_free)


def static_compliance(robot: Robot, H: Array) -> Array:
    """How rows H (m, n) at rest yield to forces along them, W = H K⁻¹ Hᵀ: (m, m) [m/N]."""
    own = robot.fork()
    return row_compliance(own.static_system(own.rest()), H, np.zeros(len(H))).W


def _by_halves(system: System, H: Array, delta: Array, halves: HalfSolving) -> Compliance:
    """The same by the first half of each solve."""
    Y = np.ascontiguousarray(halves.first_half(H.T).T)  # (m, n)
    free = delta + system.h * (H @ system.v_free)
    return Compliance(H, Y, system.h**2 * (Y @ Y.T), free, halves)


@kernel
def _condense(
    H: Array, X: Array, delta: Array, free: tuple[float, Array], W: Array, delta_free: Array
) -> None:
    """Write W (m, m), symmetric to the last bit, and δ_free (m,); free: the time step and v_free (n,)."""
    h, v_free = free
    W[:] = np.dot(H, X.T)
    for i in range(W.shape[0]):
        for j in range(i + 1):
            W[i, j] = W[j, i] = 0.5 * h * h * (W[i, j] + W[j, i])
    delta_free[:] = delta + h * np.dot(H, v_free)


def extended(system: System, known: Compliance, H: Array, delta: Array) -> Compliance:
    """Append rows to a compliance; only the new columns are solved for.

    Args:
        system: of the step.
        known: (m,) rows.
        H: (r, n) new rows.
        delta: (r,) values of the new rows [m].
    """
    if known.halves is None:
        added, left = row_compliance(system, H, delta), known.H
    else:
        added, left = _by_halves(system, H, delta, known.halves), known.Y
    cross = system.h**2 * (left @ added.Y.T)  # (m, r)
    m, size = len(known), len(known) + len(added)
    W = np.empty((size, size))
    W[:m, :m], W[:m, m:], W[m:, :m], W[m:, m:] = known.W, cross, cross.T, added.W
    return Compliance(
        np.concatenate([known.H, H]),
        np.concatenate([known.Y, added.Y]),
        W,
        np.concatenate([known.delta_free, added.delta_free]),
        known.halves,
    )
