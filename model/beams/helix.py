"""The end of a beam element from its natural strains, in the frame of its start.

An element is a helix (`tauten.model.beams.elements`): seen from its start, the relative rotation of its ends
is exp(φ) and its chord is

    r = T(φ) e,   T(φ) e = A e + B φ x e + C (φ·e) φ,   e = (L, 0, 0) + ε

with T the left Jacobian of the rotation, the mean of exp(s φ) for 0 ≤ s ≤ 1. T(φ) dφ is also the spin of
exp(φ) in a change dφ.
"""

from __future__ import annotations

import numpy as np

from tauten.model.numerics import Vector3, add, cross, dot, kernel, scale


@kernel
def helix_functions(t: float) -> tuple[float, float, float]:
    """A, B, C of T(φ) at t = |φ|."""
    t2 = t * t
    if t < 0.3:  # Taylor series, exact to rounding here
        A = 1.0 - t2 / 6.0 * (1.0 - t2 / 20.0 * (1.0 - t2 / 42.0 * (1.0 - t2 / 72.0)))
        B = 0.5 - t2 / 24.0 * (1.0 - t2 / 30.0 * (1.0 - t2 / 56.0 * (1.0 - t2 / 90.0)))
        C = 1.0 / 6.0 - t2 / 120.0 * (1.0 - t2 / 42.0 * (1.0 - t2 / 72.0 * (1.0 - t2 / 110.0)))
        return A, B, C
    sine = np.sin(t)
    return sine / t, (1.0 - np.cos(t)) / t2, (t - sine) / (t2 * t)


@kernel
def first_derivatives(t: float) -> tuple[float, float, float]:
    """A', B', C': derivatives of A, B, C by t = |φ|, divided by t."""
    t2 = t * t
    if t < 0.3:
        dA = -1.0 / 3.0 + t2 * (1.0 / 30.0 - t2 * (1.0 / 840.0 - t2 * (1.0 / 45360.0)))
        dB = -1.0 / 12.0 + t2 * (1.0 / 180.0 - t2 * (1.0 / 6720.0 - t2 * (1.0 / 453600.0)))
        dC = -1.0 / 60.0 + t2 * (1.0 / 1260.0 - t2 * (1.0 / 60480.0 - t2 * (1.0 / 4989600.0)))
        return dA, dB, dC
    A, B, C = helix_functions(t)
    return (np.cos(t) - A) / t2, (A - 2.0 * B) / t2, (B - 3.0 * C) / t2


@kernel
def second_derivatives(t: float) -> tuple[float, float, float]:
    """Derivatives of A', B', C' by t = |φ|, divided by t."""
    t2 = t * t
    if t < 0.3:
        ddA = 1.0 / 15.0 - t2 * (1.0 / 210.0 - t2 * (1.0 / 7560.0 - t2 / 498960.0))
        ddB = 1.0 / 90.0 - t2 * (1.0 / 1680.0 - t2 * (1.0 / 75600.0 - t2 / 5987520.0))
        ddC = 1.0 / 630.0 - t2 * (1.0 / 15120.0 - t2 * (1.0 / 831600.0 - t2 / 77837760.0))
        return ddA, ddB, ddC
    A, _, _ = helix_functions(t)
    dA, dB, dC = first_derivatives(t)
    return -(A + 3.0 * dA) / t2, (dA - 4.0 * dB) / t2, (dB - 5.0 * dC) / t2


@kernel
def along_helix(phi: Vector3, e: Vector3) -> Vector3:
    """T(φ) e."""
    A, B, C = helix_functions(dot(phi, phi) ** 0.5)
    return add(scale(A, e), add(scale(B, cross(phi, e)), scale(C * dot(phi, e), phi)))


@kernel
def chord_change(phi: Vector3, e: Vector3, dphi: Vector3) -> Vector3:
    """The change of T(φ) e with φ.

    Args:
        phi: φ, relative rotation of the ends.
        e: length with stretch and shear [m].
        dphi: change of φ.
    """
    t = dot(phi, phi) ** 0.5
    _, B, C = helix_functions(t)
    dA, dB, dC = first_derivatives(t)
    along, turned = dot(phi, e), dot(phi, dphi)
    part = add(scale(dA * turned, e), scale(dB * turned, cross(phi, e)))
    part = add(part, add(scale(B, cross(dphi, e)), scale(C * along, dphi)))
    return add(part, scale(C * dot(dphi, e) + dC * along * turned, phi))
