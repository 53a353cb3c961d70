"""A smoothed law of contact with friction, and how forces follow efforts under it.

With w the compliance of a contact, x = w r_n, y = u_n, and widths k for the normal and l for the slip:

    F_n = (x + y − sqrt((x − y)² + 4 (κ k)²)) / 2
    F_t = w r_t + μ w r_n⁺ u_t / sqrt(|u_t|² + (κ l)²)                                         (I4)

F = 0 is contact with friction where κ = 0: x y = (κ k)² is the central path of the normal law, and slip is
against its force with a friction that rises over the width l.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.controller.friction.problem import InverseContacts
from tauten.model.numerics import Array, kernel


@dataclass(frozen=True, slots=True)
class Widths:
    """Widths of the smoothed law.

    Attributes:
        share: κ.
        normal: (m,) k of each contact.
        slip: l.
    """

    share: float
    normal: Array
    slip: float

    def error(self, F: Array) -> float:
        """Largest |F| relative to the width of the contact."""
        return float((np.abs(F).max(axis=1) / (self.share * self.normal)).max())

    def size(self, F: Array) -> float:
        """|F| with contacts weighed by their widths: what line searches reduce."""
        return float(np.linalg.norm(F / self.normal[:, None]))


def widths(contacts: InverseContacts, r: Array, share: float, length: float) -> Widths:
    """Widths of the law at given forces, one scale of force for all contacts.

    A scale for each would hide a contact that carries little beside one that carries the weight.

    Args:
        contacts: the contacts.
        r: (3 m,) forces.
        share: κ.
        length: displacement that matters, that from the target.
    """
    largest = max(float(r[::3].max()), 0.0)
    normal = np.sqrt(length * np.maximum(length, contacts.w * largest))
    return Widths(share, normal, length)


@dataclass(frozen=True, slots=True)
class LinearLaw:
    """The smoothed law linearised: dr = residual + slope dλ meets it in the first order.

    Attributes:
        F: (m, 3) of (I4).
        residual: (3 m,).
        slope: (3 m, n_a).
    """

    F: Array
    residual: Array
    slope: Array


def smoothed_law(contacts: InverseContacts, lam: Array, r: Array, width: Widths) -> Array:
    """F (m, 3) of (I4).

    Args:
        contacts: the contacts.
        lam: (n_a,) efforts.
        r: (3 m,) forces.
        width: of the law.
    """
    F = np.empty((len(contacts.mu), 3))
    u = contacts.displacements(lam, r)
    k, slip = width.share * width.normal, width.share * width.slip
    fill_law(u, r.reshape(-1, 3), contacts.w, contacts.mu, k, slip, F)
    return F


def linear_law(contacts: InverseContacts, lam: Array, r: Array, width: Widths) -> LinearLaw:
    """Linearise (I4) in the state form: one system of the rank of W_cc, with 1 + n_a right-hand sides.

    With A = ∂F/∂u and B = ∂F/∂r, which has an inverse, dr = −B⁻¹ (F + A (G y + W_ca dλ)) where y = Gᵀ dr.

    Args:
        contacts: the contacts.
        lam: (n_a,) efforts.
        r: (3 m,) forces.
        width: of the law.
    """
    n_a, u = len(lam), contacts.displacements(lam, r)
    through = np.hstack([contacts.W_ca, contacts.G])
    rows = np.empty((len(r), 1 + through.shape[1]))  # B⁻¹ (F, A W_ca, A G)
    k, slip = width.share * width.normal, width.share * width.slip
    F = fill_rows(u, r.reshape(-1, 3), contacts.w, contacts.mu, k, slip, through, rows)
    system = contacts.G.T @ rows  # (rank, 1 + n_a + rank)
    square = system[:, 1 + n_a :]
    square[np.diag_indices_from(square)] += 1.0
    y = np.linalg.solve(square, system[:, : 1 + n_a])
    change = rows[:, 1 + n_a :] @ y - rows[:, : 1 + n_a]
    return LinearLaw(F, change[:, 0], change[:, 1:])


@kernel
def fill_law(u: Array, r: Array, w: Array, mu: Array, k: Array, slip: float, F: Array) -> None:
    """Fill F (m, 3) of (I4).

    Args:
        u: (m, 3) displacements.
        r: (m, 3) forces.
        w: (m,) compliances.
        mu: (m,) coefficients of friction.
        k: (m,) widths κ k.
        slip: width κ l.
        F: (m, 3), overwritten.
    """
    for i in range(len(w)):
        x, y = w[i] * r[i, 0], u[i, 0]
        F[i, 0] = 0.5 * (x + y - np.sqrt((x - y) ** 2 + 4.0 * k[i] * k[i]))
        speed = np.sqrt(u[i, 1] ** 2 + u[i, 2] ** 2 + slip * slip)
        pull = mu[i] * max(x, 0.0) / speed
        F[i, 1] = w[i] * r[i, 1] + pull * u[i, 1]
        F[i, 2] = w[i] * r[i, 2] + pull * u[i, 2]


@kernel
def fill_rows(
    u: Array, r: Array, w: Array, mu: Array, k: Array, slip: float, through: Array, rows: Array
) -> Array:
    """Fill rows with B⁻¹ F and B⁻¹ A through, A and B the blocks of contacts of (I4); returns F (m, 3).

    Args:
        u: (m, 3) displacements.
        r: (m, 3) forces.
        w: (m,) compliances.
        mu: (m,) coefficients of friction.
        k: (m,) widths κ k.
        slip: width κ l.
        through: (3 m, n) displacements that something else causes.
        rows: (3 m, 1 + n), overwritten.
    """
    F = np.empty(u.shape)
    fill_law(u, r, w, mu, k, slip, F)
    n = through.shape[1]
    for i in range(len(w)):
        x, y = w[i] * r[i, 0], u[i, 0]
        s = (x - y) / np.sqrt((x - y) ** 2 + 4.0 * k[i] * k[i])
        # 1 − s without cancellation where the contact is closed
        away = (
            1.0 - s
            if s < 0.9
            else 4.0 * k[i] * k[i] / (((x - y) ** 2 + 4.0 * k[i] * k[i]) * (1.0 + s))
        )
        b, ratio = 0.5 * w[i] * away, (1.0 + s) / (w[i] * away)
        speed = np.sqrt(u[i, 1] ** 2 + u[i, 2] ** 2 + slip * slip)
        push, ahead = mu[i] * max(r[i, 0], 0.0) / speed, mu[i] / speed if r[i, 0] > 0.0 else 0.0
        e_1, e_2 = u[i, 1] / speed, u[i, 2] / speed
        a_11, a_22, a_12 = push * (1.0 - e_1 * e_1), push * (1.0 - e_2 * e_2), -push * e_1 * e_2
        h_1, h_2 = ahead * u[i, 1], ahead * u[i, 2]
        row = 3 * i
        rows[row, 0] = F[i, 0] / b
        rows[row + 1, 0] = F[i, 1] / w[i] - h_1 * rows[row, 0]
        rows[row + 2, 0] = F[i, 2] / w[i] - h_2 * rows[row, 0]
        for j in range(n):
            normal = ratio * through[row, j]
            t_1, t_2 = through[row + 1, j], through[row + 2, j]
            rows[row, 1 + j] = normal
            rows[row + 1, 1 + j] = a_11 * t_1 + a_12 * t_2 - h_1 * normal
            rows[row + 2, 1 + j] = a_12 * t_1 + a_22 * t_2 - h_2 * normal
    return F
