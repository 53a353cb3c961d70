"""A clamped rod under a dead force on its end, without finite elements.

Simo's and Reissner's rod in space, integrated along its length s by a Runge-Kutta method; the moment at
the clamp is found by shooting. With force n, constant along the rod, moment m, rotation R of the
cross-section, its curvature κ₀ at rest and the stiffnesses C of stretch and shear, D of torsion and bending,

    x' = R (e₁ + C⁻¹ Rᵀ n),   R' = R [κ₀ + D⁻¹ Rᵀ m]ₓ,   m' = −x' x n,   m(L) = 0.

Source: Simo, Computer Methods in Applied Mechanics and Engineering 49, 1985.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import root
from scipy.spatial.transform import Rotation

from tauten.model.beams import Material, Profile
from tauten.model.numerics import Array

AXIS = np.array([1.0, 0.0, 0.0])


@dataclass(frozen=True)
class Rod:
    """A rod that starts at the origin.

    Attributes:
        span: last value of the parameter t along the rod, which starts at zero.
        speed: ds/dt at rest [m].
        curvature: κ₀ about the axes of the cross-section as a function of t: (3,) [1/m].
        frame: (3, 3) axes of the cross-section at the clamp in its columns: along, 2, 3.
        section: of t: C (3,), stiffness of stretch, and of shear along axes 2 and 3 [N], and D (3,), of
            torsion, and of bending about axes 2 and 3 [N m²].
    """

    span: float
    speed: Callable[[float], float]
    curvature: Callable[[float], Array]
    frame: Array
    section: Callable[[float], tuple[Array, Array]]

    def tip(self, force: Array, guess: Array) -> Array:
        """Position of the end under a dead force.

        Args:
            force: (3,) on the end [N].
            guess: (3,) position of the end that is not far off [m].
        """

        def slope(t: float, y: Array) -> Array:
            R, m = matrix(y[3:7]), y[7:]
            C, D = self.section(t)
            along = R @ (AXIS + (R.T @ force) / C)
            k = self.curvature(t) + (R.T @ m) / D
            w, v = y[3], y[4:7]
            turn = 0.5 * np.concatenate([[-v @ k], w * k + np.cross(v, k)])
            return self.speed(t) * np.concatenate([along, turn, -np.cross(along, force)])

        def end(m: Array) -> Array:
            start = np.concatenate([np.zeros(3), quaternion(self.frame), m])
            found = solve_ivp(
                slope, (0.0, self.span), start, method="DOP853", rtol=1e-10, atol=1e-10
            )
            return found.y[:, -1]

        scale = np.linalg.norm(np.cross(guess, force))
        solution = root(
            lambda m: end(m * scale)[7:] / scale, np.cross(guess, force) / scale, tol=1e-10
        )
        assert np.abs(solution.fun).max() < 1e-9, "shooting has not found the moment at the clamp"
        return end(solution.x * scale)[:3]


def stiffness(profile: Profile, material: Material) -> tuple[Array, Array]:
    """C (3,) [N] and D (3,) [N m²] of a cross-section."""
    E, G = material.young_modulus, material.shear_modulus
    C = np.array([E * profile.area, G * profile.shear_area[0], G * profile.shear_area[1]])
    return C, np.array([G * profile.torsion, E * profile.bending[0], E * profile.bending[1]])


def quaternion(frame: Array) -> Array:
    """Scalar first: (4,)."""
    return np.roll(Rotation.from_matrix(frame).as_quat(), 1)


def matrix(q: Array) -> Array:
    """Rotation matrix (3, 3) of a quaternion (4,), scalar first."""
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
