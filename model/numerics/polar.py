"""Rotations and principal stretches of deformation gradients, sixteen elements at a time."""

from __future__ import annotations

import numpy as np

from tauten.model.numerics.arrays import Array
from tauten.model.numerics.jit import kernel

LANES = 16  # elements at a time: a loop of constant length over constant strides becomes vector instructions
FLAT = 1e-6  # det F below which an element counts as inverted


@kernel
def polar_rotations(F: Array, R: Array) -> None:
    """Rotations R (n, 3, 3) of the polar decompositions F = R S by Newton's method (Higham 1986).

    An inverted or flat element gets the rotation of the singular value decomposition with the
    smallest singular direction mirrored, so that its force restores it. One that is not finite
    gets NaN.

    Args:
        F: (n, 3, 3) deformation gradients.
        R: (n, 3, 3) output.
    """
    n = F.shape[0]
    X, Y = np.empty(9 * LANES), np.empty(9 * LANES)
    for first in range(0, n, LANES):
        for lane in range(LANES):  # lanes past the last matrix repeat it
            e = min(first + lane, n - 1)
            for k in range(9):
                X[k * LANES + lane] = F[e, k // 3, k % 3]
        polar_lanes(X, Y)
        for e in range(first, min(first + LANES, n)):
            for k in range(9):
                R[e, k // 3, k % 3] = Y[k * LANES + e - first]


@kernel
def polar_lanes(F: Array, R: Array) -> None:
    """`polar_rotations` of LANES matrices at a time.

    Args:
        F: (9 LANES,) matrices, entry 3 i + j of all lanes in a row.
        R: (9 LANES,) output, in the same order.
    """
    inverted = start_lanes(F, R)
    change = np.inf
    for _ in range(30):
        # scaling makes the first iterations quadratic even for large stretch
        change = newton(R, change > 1e-2)
        if change < 1e-16:  # convergence is quadratic: what is left is rounding
            break
    if inverted == 0:
        return
    A = np.empty((3, 3))
    for lane in range(LANES):
        for k in range(9):
            A[k // 3, k % 3] = F[k * LANES + lane]
        if is_inverted(determinant(A)):
            Q = mirrored_rotation(A)
            for k in range(9):
                R[k * LANES + lane] = Q[k // 3, k % 3]


@kernel
def start_lanes(F: Array, R: Array) -> int:
    """Matrices F into R, and the identity instead of inverted ones; returns how many these are."""
    count = 0
    for lane in range(LANES):
        a, b, c = F[lane], F[LANES + lane], F[2 * LANES + lane]
        d, e, f = F[3 * LANES + lane], F[4 * LANES + lane], F[5 * LANES + lane]
        g, h, i = F[6 * LANES + lane], F[7 * LANES + lane], F[8 * LANES + lane]
        det = a * (e * i - f * h) + b * (f * g - d * i) + c * (d * h - e * g)
        inverted = is_inverted(det)
        count += 1 if inverted else 0
        for k in range(9):
            start = 1.0 if k % 4 == 0 else 0.0
            R[k * LANES + lane] = start if inverted else F[k * LANES + lane]
    return count


@kernel
def newton(X: Array, scaled: bool) -> float:
    """One iteration X ← (ζ X + X⁻ᵀ / ζ) / 2 of every lane; the sum of the squared changes."""
    change = 0.0
    for k in range(LANES):
        a, b, c = X[k], X[LANES + k], X[2 * LANES + k]
        d, e, f = X[3 * LANES + k], X[4 * LANES + k], X[5 * LANES + k]
        g, h, i = X[6 * LANES + k], X[7 * LANES + k], X[8 * LANES + k]
        ca, cb, cc = e * i - f * h, f * g - d * i, d * h - e * g
        cd, ce, cf = c * h - b * i, a * i - c * g, b * g - a * h
        cg, ch, ci = b * f - c * e, c * d - a * f, a * e - b * d
        det = a * ca + b * cb + c * cc
        zeta = 1.0
        if scaled:
            norm = a * a + b * b + c * c + d * d + e * e + f * f + g * g + h * h + i * i
            of_cofactors = ca * ca + cb * cb + cc * cc + cd * cd + ce * ce + cf * cf
            of_cofactors += cg * cg + ch * ch + ci * ci
            zeta = np.sqrt(np.sqrt(of_cofactors / norm) / det)
        x, y = 0.5 * zeta - 1.0, 0.5 / (zeta * det)
        da, db, dc = x * a + y * ca, x * b + y * cb, x * c + y * cc
        dd, de, df = x * d + y * cd, x * e + y * ce, x * f + y * cf
        dg, dh, di = x * g + y * cg, x * h + y * ch, x * i + y * ci
        X[k], X[LANES + k], X[2 * LANES + k] = a + da, b + db, c + dc
        X[3 * LANES + k], X[4 * LANES + k], X[5 * LANES + k] = d + dd, e + de, f + df
        X[6 * LANES + k], X[7 * LANES + k], X[8 * LANES + k] = g + dg, h + dh, i + di
        change += da * da + db * db + dc * dc + dd * dd + de * de + df * df
        change += dg * dg + dh * dh + di * di
    return change


@kernel
def is_inverted(det: float) -> bool:
    """Whether a matrix with this determinant is no rotation and stretch.

    Not where it is not finite: numba's singular value decomposition fails on infinity.
    """
    return bool(-np.inf < det <= FLAT)


@kernel
def determinant(F: Array) -> float:
    """Of a 3x3 matrix."""
    value = F[0, 0] * (F[1, 1] * F[2, 2] - F[1, 2] * F[2, 1])
    value += F[0, 1] * (F[1, 2] * F[2, 0] - F[1, 0] * F[2, 2])
    return float(value + F[0, 2] * (F[1, 0] * F[2, 1] - F[1, 1] * F[2, 0]))


@kernel
def mirrored_rotation(F: Array) -> Array:
    """The rotation of an inverted F: of its singular value decomposition, the smallest direction mirrored."""
    U, _, Vt = np.linalg.svd(F)
    R: Array = U @ Vt
    if determinant(R) < 0.0:
        U[:, 2] = -U[:, 2]
        R = U @ Vt
    return R
