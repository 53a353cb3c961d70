"""Unit quaternions (w, x, y, z), rotations without singular angles: as tuples for kernels, then as arrays."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from tauten.model.numerics.arrays import Array
from tauten.model.numerics.jit import kernel
from tauten.model.numerics.vector import Vector3, cross, length, row, scale

Quaternion: TypeAlias = tuple[float, float, float, float]


@kernel
def quaternion(Q: Array, i: int) -> Quaternion:
    """Row i of Q (m, 4)."""
    return (Q[i, 0], Q[i, 1], Q[i, 2], Q[i, 3])


@kernel
def product(a: Quaternion, b: Quaternion) -> Quaternion:
    """The rotation b followed by a."""
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    )


@kernel
def conjugate(a: Quaternion) -> Quaternion:
    """The opposite rotation."""
    return (a[0], -a[1], -a[2], -a[3])


@kernel
def normalised(a: Quaternion) -> Quaternion:
    """The quaternion brought to unit length."""
    s = (a[0] * a[0] + a[1] * a[1] + a[2] * a[2] + a[3] * a[3]) ** -0.5
    return (s * a[0], s * a[1], s * a[2], s * a[3])


@kernel
def rotate(a: Quaternion, r: Vector3) -> Vector3:
    """The vector r turned by a: r + 2 (w t + v x t) with t = v x r."""
    v = (a[1], a[2], a[3])
    t = cross(v, r)
    s = cross(v, t)
    return (
        r[0] + 2.0 * (a[0] * t[0] + s[0]),
        r[1] + 2.0 * (a[0] * t[1] + s[1]),
        r[2] + 2.0 * (a[0] * t[2] + s[2]),
    )


@kernel
def rotation_vector(a: Quaternion) -> Vector3:
    """Axis times angle of a, the angle in 0 … π [rad]."""
    sign = 1.0 if a[0] >= 0.0 else -1.0
    s = (a[1] * a[1] + a[2] * a[2] + a[3] * a[3]) ** 0.5
    # for s → 0 the ratio angle / s tends to 2 / w
    ratio = 2.0 * np.arctan2(s, sign * a[0]) / s if s > 1e-12 else 2.0
    return scale(sign * ratio, (a[1], a[2], a[3]))


@kernel
def from_rotation_vector(r: Vector3) -> Quaternion:
    """The rotation about r by |r| [rad]."""
    half = 0.5 * length(r)
    ratio = 0.5 * np.sin(half) / half if half > 1e-8 else 0.5
    return (np.cos(half), ratio * r[0], ratio * r[1], ratio * r[2])


@kernel
def turned(Q: Array, increment: Array) -> Array:
    """Rotations Q (m, 4) followed by small ones about fixed axes (m, 3) [rad]: (m, 4), unit."""
    result = np.empty_like(Q)
    for i in range(Q.shape[0]):
        after = from_rotation_vector(row(increment, i))
        result[i] = np.array(normalised(product(after, quaternion(Q, i))))
    return result


@kernel
def rotations_between(first: Array, last: Array) -> Array:
    """Rotation vectors (m, 3) about fixed axes [rad] that turn rotations (m, 4) into others (m, 4)."""
    result = np.empty((first.shape[0], 3))
    for i in range(first.shape[0]):
        turn = product(quaternion(last, i), conjugate(quaternion(first, i)))
        result[i] = np.array(rotation_vector(turn))
    return result


def moments_at_end(theta: Array, moment: Array) -> Array:
    """Moments (m, 3) [N m] at the end of turns that do the work of given ones on their rotation vectors.

    Where the end of a turn θ is turned further by a small δ, θ grows by L⁻¹(θ) δ, with the left Jacobian L of
    the exponential map, so that moments are multiplied by L⁻ᵀ. Rotation vectors θ (m, 3) are about fixed
    axes, from `rotations_between` [rad].
    """
    half = np.maximum(0.5 * np.linalg.norm(theta, axis=1, keepdims=True), 1e-4)
    factor = (1.0 - half / np.tan(half)) / (4.0 * half * half)  # 1/12 at zero
    across = np.cross(theta, moment)
    found: Array = moment + 0.5 * across + factor * np.cross(theta, across)
    return found


@kernel
def matrix_quaternion(R: Array) -> Array:
    """The unit quaternion (4,) with w ≥ 0 of a rotation matrix (3, 3), by its largest component."""
    q = np.empty(4)
    t = R[0, 0] + R[1, 1] + R[2, 2]
    squares = (t, 2.0 * R[0, 0] - t, 2.0 * R[1, 1] - t, 2.0 * R[2, 2] - t)  # 4 q_i² − 1
    i = 0
    for k in range(1, 4):
        if squares[k] > squares[i]:
            i = k
    if i == 0:
        q[0] = 1.0 + t
        q[1], q[2], q[3] = R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]
    elif i == 1:
        q[1] = 1.0 + squares[1]
        q[0], q[2], q[3] = R[2, 1] - R[1, 2], R[0, 1] + R[1, 0], R[0, 2] + R[2, 0]
    elif i == 2:
        q[2] = 1.0 + squares[2]
        q[0], q[1], q[3] = R[0, 2] - R[2, 0], R[0, 1] + R[1, 0], R[1, 2] + R[2, 1]
    else:
        q[3] = 1.0 + squares[3]
        q[0], q[1], q[2] = R[1, 0] - R[0, 1], R[0, 2] + R[2, 0], R[1, 2] + R[2, 1]
    size = np.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    unit: Array = q / (size if q[0] >= 0.0 else -size)
    return unit


@kernel
def rotation_between(start: Array, end: Array) -> Array:
    """The rotation vector (3,) [rad] that turns the rotation `start` into `end`, about the axes of `start`.

    exp(r) = start⁻¹ end, with an angle of at most π; q and −q are the same rotation.

    Args:
        start: (4,) unit quaternion.
        end: (4,) unit quaternion.
    """
    first = (start[0], start[1], start[2], start[3])
    r = rotation_vector(product(conjugate(first), (end[0], end[1], end[2], end[3])))
    found: Array = np.array((r[0], r[1], r[2]))
    return found


@kernel
def rotated_by(start: Array, r: Array) -> Array:
    """The unit quaternion (4,), w ≥ 0, of `start` (4,) turned about its own axes by a vector r (3,) [rad]."""
    turn = from_rotation_vector((r[0], r[1], r[2]))
    q = np.array(normalised(product((start[0], start[1], start[2], start[3]), turn)))
    positive: Array = q if q[0] >= 0.0 else -q
    return positive
