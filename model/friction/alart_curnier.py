"""The residual of Alart and Curnier, whose zeros solve contact with friction, and its Jacobian.

With forces and velocities of one unit (each contact scaled by its compliance) and a weight c > 0:

    F_n = r_n − (r_n − c u_n)⁺,   F_t = r_t − P(r_t − c u_t; μ (r_n − c u_n)⁺)                      (F1)

P projects on the disc with that radius (Computer Methods in Applied Mechanics and Engineering 92, 1991).
F is piecewise smooth: open, sticking and slipping contacts have rows of their own in its Jacobian.
"""

from __future__ import annotations

import numpy as np

from tauten.model.numerics import Array, kernel, solve_linear


@kernel
def residual(u: Array, r: Array, mu: Array, c: float, F: Array) -> float:
    """Fill F (m, d) of (F1); returns its square.

    Args:
        u: (m, d) velocities.
        r: (m, d) forces.
        mu: (m,) coefficients of friction.
        c: weight of the velocities.
        F: (m, d), overwritten.
    """
    m, d = u.shape
    total = 0.0
    for i in range(m):
        pushed = r[i, 0] - c * u[i, 0]
        radius = mu[i] * pushed
        length = 0.0
        for j in range(1, d):
            length += (r[i, j] - c * u[i, j]) ** 2
        length = np.sqrt(length)
        F[i, 0] = r[i, 0] if pushed <= 0.0 else c * u[i, 0]
        for j in range(1, d):
            if pushed <= 0.0:
                F[i, j] = r[i, j]
            elif length <= radius:
                F[i, j] = c * u[i, j]
            else:
                F[i, j] = r[i, j] - radius / length * (r[i, j] - c * u[i, j])
        for j in range(d):
            total += F[i, j] * F[i, j]
    return total


@kernel
def newton_step(u: Array, r: Array, mu: Array, c: float, W: Array, F: Array) -> tuple[bool, Array]:
    """A Newton step on F(r, W r + q), with an element of its generalised Jacobian: dr (m d,).

    Forces of open contacts become zero, so that only those of contacts that push are unknown. False where
    the system is singular.

    Args:
        u: (m, d) velocities.
        r: (m, d) forces.
        mu: (m,) coefficients of friction.
        c: weight of the velocities.
        W: (m d, m d) compliance.
        F: (m, d) of (F1).
    """
    d = u.shape[1]
    pushing = np.flatnonzero(r[:, 0] - c * u[:, 0] > 0.0)
    rows, size = (d * pushing.repeat(d).reshape((-1, d)) + np.arange(d)).ravel(), d * len(pushing)
    dr = -r.copy().ravel()
    dr[rows] = 0.0
    V = np.zeros((size, size + 1))  # c W of what pushes, and c times what open contacts move
    for k, row in enumerate(rows):
        for j, column in enumerate(rows):
            V[k, j] = c * W[row, column]
    if np.abs(dr).max() > 0.0:
        for k, row in enumerate(rows):
            V[k, size] = c * np.dot(W[row], dr)
    for k, i in enumerate(pushing):
        y, radius = r[i] - c * u[i], mu[i] * (r[i, 0] - c * u[i, 0])
        length = np.sqrt((y[1:] ** 2).sum())
        if length > radius:
            slide(V[k * d : (k + 1) * d], y / length, mu[i], radius / length, k * d)
    b = -F.ravel()[rows] - V[:, size]
    solved, found = solve_linear(np.ascontiguousarray(V[:, :size]), b.reshape((-1, 1)))
    dr[rows] = found[:, 0]
    return solved, dr


@kernel
def slide(V: Array, e: Array, mu: float, share: float, first: int) -> None:
    """Make rows c W (d, n) of a contact those of a contact that slips, F_j = r_j − μ pushed e_j, in place.

    Args:
        V: (d, n) rows of the contact, overwritten.
        e: (d,) direction of r_t − c u_t, from 1 on.
        mu: coefficient of friction.
        share: radius of the disc by |r_t − c u_t|.
        first: column of the contact's normal force.
    """
    d, n = V.shape
    for column in range(n):
        along = 0.0
        for j in range(1, d):
            along += e[j] * V[j, column]
        for j in range(1, d):
            turned = share * (V[j, column] - e[j] * along)
            V[j, column] = turned + mu * e[j] * V[0, column]
    for j in range(1, d):
        for k in range(1, d):
            V[j, first + k] += share * e[j] * e[k]
        V[j, first + j] += 1.0 - share
        V[j, first] -= mu * e[j]
