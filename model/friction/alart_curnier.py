"""The residual of Alart and Curnier, whose zeros solve contact with friction, and its Jacobian.

With forces and velocities of one unit (each contact scaled by its compliance) and a weight c > 0:

    F_n = r_n − (r_n − c u_n)⁺,   F_t = r_t − P(r_t − c u_t; μ (r_n − c u_n)⁺)                      (F1)

P projects on the disc with that radius (Computer Methods in Applied Mechanics and Engineering 92, 1991).
F is piecewise smooth: open, sticking and slipping contacts have rows of their own in its Jacobian.
"""

from __future__ import annotations

import numpy as np

from tauten.model.numerics import Array, kernel


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
def jacobian(u: Array, r: Array, mu: Array, c: float, W: Array) -> Array:
    """A + B W (m d, m d), an element of the generalised Jacobian of F(r, W r + q).

    Args:
        u: (m, d) velocities.
        r: (m, d) forces.
        mu: (m,) coefficients of friction.
        c: weight of the velocities.
        W: (m d, m d) compliance.
    """
    m, d = u.shape
    J = np.zeros((m * d, m * d))
    y = np.empty(d)
    for i in range(m):
        pushed, row = r[i, 0] - c * u[i, 0], i * d
        if pushed <= 0.0:
            for j in range(d):
                J[row + j, row + j] = 1.0
            continue
        J[row] = c * W[row]
        radius, length = mu[i] * pushed, 0.0
        for j in range(1, d):
            y[j] = r[i, j] - c * u[i, j]
            length += y[j] * y[j]
        length = np.sqrt(length)
        if length <= radius:
            for j in range(1, d):
                J[row + j] = c * W[row + j]
            continue
        share = radius / length
        for j in range(1, d):
            # F_j = r_j − radius e_j with e = y / |y|: first what y moves, then what the radius does
            for k in range(1, d):
                turned = share * ((1.0 if j == k else 0.0) - y[j] * y[k] / length**2)
                J[row + j] += c * turned * W[row + k]
                J[row + j, row + k] -= turned
            J[row + j, row + j] += 1.0
            wider = mu[i] * y[j] / length
            J[row + j] += c * wider * W[row]
            J[row + j, row] -= wider
    return J
