"""Contact with Coulomb friction: what is to be solved, and how far an answer is from it.

Every contact has a force r = (r_n, r_t) and a velocity or displacement u = (u_n, u_t), the normal first:

    u = W r + q,   û = u + μ |u_t| n,   K* ∋ û ⟂ r ∈ K = {|r_t| ≤ μ r_n}

(De Saxcé and Feng, Mathematical and Computer Modelling 28, 1998): a contact is open, or it sticks within its
cone, or it slips against its force. W is symmetric positive semidefinite, and mostly singular, so that r need
not be unique.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tauten.model.numerics import Array, kernel


@dataclass(frozen=True, slots=True)
class FrictionProblem:
    """Contacts with friction of a step, or of a file; rows of a contact follow one another.

    Attributes:
        W: (m d, m d) compliance between the rows.
        q: (m d,) velocities or displacements without contact forces.
        mu: (m,) coefficients of friction, not negative.

    Raises:
        ValueError: shapes or values that do not fit; the message says which.
    """

    W: Array
    q: Array
    mu: Array

    def __post_init__(self) -> None:
        """Check shapes and values."""
        rows, m = len(self.q), len(self.mu)
        if m == 0 or rows not in (2 * m, 3 * m):
            raise ValueError(f"q: found {rows} rows for {m} contacts, expected 2 or 3 for each")
        if self.W.shape != (rows, rows):
            raise ValueError(f"W: found shape {self.W.shape}, expected ({rows}, {rows})")
        if not (np.isfinite(self.W).all() and np.isfinite(self.q).all()):
            raise ValueError("W, q: found values that are not finite")
        if not (np.isfinite(self.mu).all() and (self.mu >= 0.0).all()):
            raise ValueError("mu: found a value that is negative or not finite, expected 0 or more")
        if not (self.compliance > 0.0).all():
            raise ValueError("W: found a contact without compliance, expected a positive diagonal")

    @property
    def dim(self) -> int:
        """Rows of a contact: 2 or 3."""
        return len(self.q) // len(self.mu)

    @property
    def compliance(self) -> Array:
        """Largest compliance of each contact (m,), along its normal or in any direction across it."""
        contacts = np.arange(len(self.mu))
        W = self.W.reshape(2 * (len(contacts), self.dim))[contacts, :, contacts]  # (m, d, d)
        across = np.linalg.eigvalsh(W[:, 1:, 1:])[:, -1]
        found: Array = np.maximum(W[:, 0, 0], across)
        return found

    def error(self, r: Array) -> float:
        """Largest |r − P_K(r − ρ û)| / ρ along or across a normal, ρ = 1 / `compliance`, in the unit of q.

        Args:
            r: (m d,) contact forces.
        """
        shape = (len(self.mu), self.dim)
        u = (self.W @ r + self.q).reshape(shape)
        return natural_error(u, r.reshape(shape), self.mu, self.compliance)


class Cones(NamedTuple):
    """The arrays of a `FrictionProblem`.

    Attributes:
        W: (m d, m d) compliance.
        q: (m d,) velocities or displacements without contact forces.
        mu: (m,) coefficients of friction.
        W_ii: (m,) largest compliance of each contact.
    """

    W: Array
    q: Array
    mu: Array
    W_ii: Array


@kernel
def velocities(cones: Cones, r: Array) -> Array:
    """Velocities u (m, d) under forces (m d,)."""
    m = len(cones.mu)
    u: Array = np.dot(cones.W, r) + cones.q
    return u.reshape((m, len(r) // m))


@kernel
def error_of(cones: Cones, r: Array) -> float:
    """Error of the natural map of forces (m d,) [unit of q]."""
    u = velocities(cones, r)
    return natural_error(u, r.reshape(u.shape), cones.mu, cones.W_ii)


@kernel
def natural_error(u: Array, r: Array, mu: Array, W_ii: Array) -> float:
    """Largest length of the natural map of the cones along or across a normal [unit of u]; NaN where one is.

    Args:
        u: (m, d) velocities or displacements.
        r: (m, d) forces.
        mu: (m,) coefficients of friction.
        W_ii: (m,) compliances by which forces become displacements.
    """
    m, d = u.shape
    largest, z = 0.0, np.empty(d)
    for i in range(m):
        slip = 0.0
        for j in range(1, d):
            slip += u[i, j] * u[i, j]
        z[0] = r[i, 0] - (u[i, 0] + mu[i] * np.sqrt(slip)) / W_ii[i]
        for j in range(1, d):
            z[j] = r[i, j] - u[i, j] / W_ii[i]
        into_cone(z, mu[i])
        across = 0.0
        for j in range(1, d):
            across += (r[i, j] - z[j]) ** 2
        error = np.maximum(abs(r[i, 0] - z[0]), np.sqrt(across))
        largest = np.maximum(largest, W_ii[i] * error)
    return largest


@kernel
def into_cone(z: Array, mu: float) -> None:
    """Project z (d,) on the cone |z_t| ≤ μ z_n, in place."""
    tangent = 0.0
    for j in range(1, len(z)):
        tangent += z[j] * z[j]
    tangent = np.sqrt(tangent)
    if tangent <= mu * z[0] and z[0] >= 0.0:  # without friction the cone is a half-line
        return
    normal = max((z[0] + mu * tangent) / (1.0 + mu * mu), 0.0) if mu * tangent > -z[0] else 0.0
    share = mu * normal / tangent if tangent > 0.0 else 0.0
    z[0] = normal
    for j in range(1, len(z)):
        z[j] *= share
