"""Three-vectors as tuples, for kernels: numba keeps them in registers."""

from __future__ import annotations

from typing import TypeAlias

from tauten.model.numerics.arrays import Array
from tauten.model.numerics.jit import kernel

Vector3: TypeAlias = tuple[float, float, float]


@kernel
def row(x: Array, i: int) -> Vector3:
    """Row i of x (m, 3)."""
    return (x[i, 0], x[i, 1], x[i, 2])


@kernel
def add(a: Vector3, b: Vector3) -> Vector3:
    """The sum a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@kernel
def subtract(a: Vector3, b: Vector3) -> Vector3:
    """The difference a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@kernel
def scale(s: float, a: Vector3) -> Vector3:
    """The multiple s a."""
    return (s * a[0], s * a[1], s * a[2])


@kernel
def dot(a: Vector3, b: Vector3) -> float:
    """The inner product a · b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def cross(a: Vector3, b: Vector3) -> Vector3:
    """The vector product a x b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@kernel
def length(a: Vector3) -> float:
    """The Euclidean norm of a."""
    return float(dot(a, a) ** 0.5)


@kernel
def unit(a: Vector3) -> Vector3:
    """The direction of a; zero for the zero vector."""
    norm = length(a)
    return scale(1.0 / norm, a) if norm > 0.0 else a
