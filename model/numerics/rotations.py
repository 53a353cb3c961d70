"""Rotations as matrices, quaternions (w, x, y, z) and rotation vectors, converted one at a time."""

from __future__ import annotations

import numpy as np

from tauten.model.numerics.arrays import Array
from tauten.model.numerics.jit import kernel
from tauten.model.numerics.quaternions import (
    conjugate,
    from_rotation_vector,
    normalised,
    product,
    rotation_vector,
)


@kernel
def rotation_matrix(q: Array) -> Array:
    """The matrix (3, 3) of a unit quaternion (4,)."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    R = np.empty((3, 3))
    R[0, 0], R[0, 1], R[0, 2] = (
        1.0 - 2.0 * (y * y + z * z),
        2.0 * (x * y - w * z),
        2.0 * (x * z + w * y),
    )
    R[1, 0], R[1, 1], R[1, 2] = (
        2.0 * (x * y + w * z),
        1.0 - 2.0 * (x * x + z * z),
        2.0 * (y * z - w * x),
    )
    R[2, 0], R[2, 1], R[2, 2] = (
        2.0 * (x * z - w * y),
        2.0 * (y * z + w * x),
        1.0 - 2.0 * (x * x + y * y),
    )
    return R


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
    return q / (size if q[0] >= 0.0 else -size)


@kernel
def rotation_between(start: Array, end: Array) -> Array:
    """The rotation vector (3,) [rad] that turns the rotation `start` into `end`, about the axes of `start`.

    exp(r) = start⁻¹ end, with an angle of at most π; q and −q are the same rotation.

    Args:
        start: (4,) unit quaternion.
        end: (4,) unit quaternion.
    """
    first = (start[0], start[1], start[2], start[3])
    return np.array(rotation_vector(product(conjugate(first), (end[0], end[1], end[2], end[3]))))


@kernel
def rotated_by(start: Array, r: Array) -> Array:
    """The unit quaternion (4,), w ≥ 0, of `start` (4,) turned about its own axes by a vector r (3,) [rad]."""
    turn = from_rotation_vector((r[0], r[1], r[2]))
    q = np.array(normalised(product((start[0], start[1], start[2], start[3]), turn)))
    positive: Array = q if q[0] >= 0.0 else -q
    return positive
