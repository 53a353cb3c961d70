"""Compliance between rows: change of one row's value per force on another within a step.

W = h² H A⁻¹ Hᵀ,   δ_free = δ + h H v_free,   δ = δ_free + W λ               (11)-(12)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.numerics import Array, kernel
from tauten.model.signals import Springs
from tauten.model.system import System


@dataclass(frozen=True, slots=True)
class Compliance:
    """Rows condensed through the system of one step.

    Attributes:
        H: (m, n) dense rows.
        X: (m, n) = (A⁻¹ Hᵀ)ᵀ, velocity change per constraint impulse.
        W: (m, m) compliance [m/N].
        delta_free: (m,) row values after a step without constraint forces [m].
    """

    H: Array
    X: Array
    W: Array
    delta_free: Array

    def __len__(self) -> int:
        return len(self.delta_free)

    def velocity_change(self, system: System, lam: Array) -> Array:
        """Dv of a step under constraint forces lam (m,): (n,) [m/s]."""
        change: Array = system.v_free - system.v + system.h * (lam @ self.X)
        return change

    def spring(self, springs: Springs, actuators: slice) -> None:
        """Take the rows of actuators from their ends to their motors, before their springs."""
        between = self.W[actuators, actuators]
        between[np.diag_indices(len(between))] += springs.flexibility
        self.delta_free[actuators] += springs.shift


def row_compliance(system: System, H: Array, delta: Array) -> Compliance:
    """Condense dense rows through one factorised system.

    Args:
        system: of the step.
        H: (m, n) rows.
        delta: (m,) row values [m].
    """
    X = np.ascontiguousarray(system.factorisation.solve(H.T).T)  # (m, n)
    W, delta_free = np.empty((len(H), len(H))), np.empty(len(H))
    _condense(H, X, delta, (system.h, system.v_free), W, delta_free)
    return Compliance(H, X, W, delta_free)


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
    X = np.ascontiguousarray(system.factorisation.solve(H.T).T)  # (r, n)
    rows, m, n = len(known) + len(H), len(known), H.shape[1]
    found = Compliance(
        np.empty((rows, n)), np.empty((rows, n)), np.empty((rows, rows)), np.empty(rows)
    )
    found.H[:m], found.X[:m], found.W[:m, :m] = known.H, known.X, known.W
    found.H[m:], found.X[m:], found.delta_free[:m] = H, X, known.delta_free
    cross = system.h**2 * (known.H @ X.T)  # (m, r)
    found.W[:m, m:], found.W[m:, :m] = cross, cross.T
    free = system.h, system.v_free
    _condense(H, X, delta, free, found.W[m:, m:], found.delta_free[m:])
    return found
