"""Shapes that a robot may touch, given by their signed distance in a frame of their own.

Other packages add shapes of the same interface by entry points (docs/extend.md). Each takes its parameters as
keywords, and refuses those that make no shape by a ValueError.
"""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np

from tauten.model.arguments import positive
from tauten.model.contact.outlines import RodOutline, across, box, square
from tauten.model.extension_error import shape_fault
from tauten.model.numerics import Array, Ints, kernel

_SHORTEST = 1e-9  # m, below which a length is none


class Shape(Protocol):
    """What a robot may touch."""

    def closest(self, points: Array) -> tuple[Array, Array]:
        """Signed distances (m,) of points (m, 3) to it [m], negative inside, and their gradients (m, 3).

        The gradient of a distance is a unit vector, which points from the nearest point of the shape to the
        point, and inside the other way.
        """


class NearShape(Shape, Protocol):
    """A shape that is faster where only points near it count."""

    def closest_within(self, points: Array, reach: float) -> tuple[Array, Array]:
        """As `closest`; the distance of a point farther than `reach` [m] outside may be +inf."""


@runtime_checkable
class DrawnShape(Shape, Protocol):
    """A shape that can be drawn; one of another package is, where it has this."""

    def outline(self, centre: Array, extent: float) -> tuple[Array, Ints]:
        """Vertices (v, 3) [m] and triangles (t, 3) of its surface.

        Shapes without end are drawn around a centre (3,), that of the robot, as large as `extent` [m].
        """


def distances_fault(found: object, m: int) -> str:
    """What is wrong with what a shape gives for m points; "" where nothing is."""
    if not isinstance(found, tuple | list) or len(found) != 2:
        return f"gives a {type(found).__name__}, expected is a tuple of distances and normals"
    gap, normal = found
    return shape_fault(("distances", gap, (m,)), ("normals", normal, (m, 3)))


def outline_fault(found: object) -> str:
    """What is wrong with the outline that a shape gives; "" where nothing is."""
    if not isinstance(found, tuple | list) or len(found) != 2:
        return f"gives a {type(found).__name__}, expected is a tuple of vertices and triangles"
    vertices, triangles = found
    v, t = (len(one) if np.ndim(one) else 0 for one in found)
    fault = shape_fault(("vertices", vertices, (v, 3)), ("triangles", triangles, (t, 3)))
    if fault or t == 0:
        return fault
    if triangles.dtype.kind not in "iu" or triangles.min() < 0 or triangles.max() >= v:
        return f"gives triangles that are not three numbers of its {v} vertices, counted from 0"
    return "" if np.isfinite(vertices).all() else "gives vertices that are not finite"


class PlaneShape:
    """A half-space: all that lies behind a plane."""

    def __init__(self, point: Array, normal: Array) -> None:
        """Through a point (3,) [m], with a normal (3,) of any length towards the robot.

        Raises:
            ValueError: these are not three numbers each, or the normal has no direction.
        """
        self._point = vector("point", point)
        self._normal = direction("normal", normal)

    def closest(self, points: Array) -> tuple[Array, Array]:
        """Distances (m,) of points (m, 3) [m], and the normal for each (m, 3)."""
        return over_plane(points, self._point, self._normal)

    def outline(self, centre: Array, extent: float) -> tuple[Array, Ints]:
        """A square of the plane as large as `extent`, nearest to a centre (3,) [m]."""
        away = float((centre - self._point) @ self._normal)
        return square(centre - away * self._normal, self._normal, extent)


class RodShape:
    """A shape that is drawn as a rod or a ball."""

    rod: RodOutline

    def outline(self, centre: Array, extent: float) -> tuple[Array, Ints]:
        """Vertices (v, 3) [m] and triangles (t, 3) of it."""
        return self.rod.triangles()


class SphereShape(RodShape):
    """A ball."""

    def __init__(self, centre: Array, radius: float) -> None:
        """Around a centre (3,), with a radius [m].

        Raises:
            ValueError: the centre is not three numbers, or the radius is not positive.
        """
        self._centre, self._radius = vector("centre", centre), positive("radius", radius)
        self.rod = RodOutline(self._centre, np.zeros(3), self._radius)

    def closest(self, points: Array) -> tuple[Array, Array]:
        """Distances (m,) of points (m, 3) [m], and their gradients (m, 3)."""
        return around(points - self._centre, self._radius)


class CapsuleShape(RodShape):
    """All within a distance of the line between two points: a rod with round ends."""

    def __init__(self, start: Array, end: Array, radius: float) -> None:
        """Between the centres (3,) of both ends, with a radius [m].

        Raises:
            ValueError: a centre is not three numbers, they coincide, or the radius is not positive.
        """
        self._start, self._radius = vector("start", start), positive("radius", radius)
        self._along = vector("end", end) - self._start
        if np.linalg.norm(self._along) < _SHORTEST:
            raise ValueError("end: coincides with start; a ball is a sphere")
        self.rod = RodOutline(self._start, self._along, self._radius)

    def closest(self, points: Array) -> tuple[Array, Array]:
        """Distances (m,) of points (m, 3) [m], and their gradients (m, 3)."""
        away = points - self._start
        share = np.clip(away @ self._along / (self._along @ self._along), 0.0, 1.0)  # (m,)
        return around(away - share[:, None] * self._along, self._radius)


class CylinderShape(RodShape):
    """A rod with flat ends."""

    def __init__(self, start: Array, end: Array, radius: float) -> None:
        """Between the centres (3,) of both ends, with a radius [m].

        Raises:
            ValueError: a centre is not three numbers, they coincide, or the radius is not positive.
        """
        first, self._radius = vector("start", start), positive("radius", radius)
        along = vector("end", end) - first
        self._half = 0.5 * float(np.linalg.norm(along))
        if self._half < _SHORTEST:
            raise ValueError("end: coincides with start; a cylinder has a length")
        self._centre, self._axis = first + 0.5 * along, along / (2.0 * self._half)
        self.rod = RodOutline(first, along, self._radius, flat=True)

    def closest(self, points: Array) -> tuple[Array, Array]:
        """Distances (m,) of points (m, 3) [m], inside to the nearest face, and their gradients (m, 3)."""
        away = points - self._centre
        height = away @ self._axis  # (m,)
        flat = away - height[:, None] * self._axis
        width = np.linalg.norm(flat, axis=1)  # (m,)
        flat = np.where((width > 0.0)[:, None], flat, across(self._axis)[0])
        side = flat / np.where(width > 0.0, width, 1.0)[:, None]
        end = np.copysign(1.0, height)[:, None] * self._axis  # (m, 3)
        beyond = np.stack([np.abs(height) - self._half, width - self._radius], axis=1)
        gap, out, length = beyond_faces(beyond)
        return gap, (out[:, :1] * end + out[:, 1:] * side) / length[:, None]


class BoxShape:
    """A box along the axes of its frame."""

    def __init__(self, lower: Array, upper: Array) -> None:
        """Between the corners (3,) with the least and with the largest coordinates [m].

        Raises:
            ValueError: a corner is not three numbers, or `upper` is not larger than `lower`.
        """
        low, high = vector("lower", lower), vector("upper", upper)
        if not (high > low).all():
            raise ValueError(f"upper: {high.tolist()} must be larger than lower, {low.tolist()}")
        self._centre, self._half = 0.5 * (low + high), 0.5 * (high - low)

    def closest(self, points: Array) -> tuple[Array, Array]:
        """Distances (m,) of points (m, 3) [m], inside to the nearest face, and their gradients (m, 3)."""
        away = points - self._centre
        beyond = np.abs(away) - self._half  # (m, 3), of the faces
        gap, out, length = beyond_faces(beyond)
        return gap, np.copysign(out, away) / length[:, None]

    def outline(self, centre: Array, extent: float) -> tuple[Array, Ints]:
        """Vertices (8, 3) [m] and triangles (12, 3) of the box."""
        return box(self._centre - self._half, self._centre + self._half)


SHAPES = {
    "plane": PlaneShape, "sphere": SphereShape, "capsule": CapsuleShape, "cylinder": CylinderShape,
    "box": BoxShape,
}  # fmt: skip


def around(away: Array, radius: float) -> tuple[Array, Array]:
    """Distances (m,) of points to what reaches a radius from a centre [m], and their gradients (m, 3).

    Points are `away` (m, 3) from their nearest centres [m]; at the centre itself the gradient is +z.
    """
    length = np.linalg.norm(away, axis=1)  # (m,)
    far = length > 0.0
    normal = np.where(far[:, None], away, [0.0, 0.0, 1.0])
    return length - radius, normal / np.where(far, length, 1.0)[:, None]


def beyond_faces(beyond: Array) -> tuple[Array, Array, Array]:
    """Distances (m,) of points to a convex body whose faces are across each other, and the way out of it.

    Args:
        beyond: (m, k) of the points and the faces, negative inside [m].

    Returns:
        gap (m,) [m], inside to the nearest face; out (m, k) along the normals of the faces; length (m,) of
        out.
    """
    inside = beyond.max(axis=1) <= 0.0
    nearest = np.eye(beyond.shape[1])[beyond.argmax(axis=1)]  # (m, k), the face of points inside
    out = np.where(inside[:, None], nearest, np.maximum(beyond, 0.0))
    length = np.linalg.norm(out, axis=1)
    return np.where(inside, beyond.max(axis=1), length), out, length


def vector(name: str, value: Array) -> Array:
    """Three finite numbers, or a ValueError that names the parameter."""
    found = np.asarray(value, dtype=float)
    if found.shape != (3,) or not np.isfinite(found).all():
        raise ValueError(f"{name}: expected three numbers [m], found {np.asarray(value).tolist()}")
    return found


def direction(name: str, value: Array) -> Array:
    """A unit vector (3,) along three numbers, or a ValueError that names the parameter."""
    found = vector(name, value)
    length = float(np.linalg.norm(found))
    if not length > _SHORTEST:
        raise ValueError(f"{name}: {found.tolist()} has no direction")
    unit: Array = found / length
    return unit


@kernel
def over_plane(points: Array, point: Array, normal: Array) -> tuple[Array, Array]:
    """Distances (m,) of points (m, 3) from a plane [m], and its normal for each (m, 3).

    Args:
        points: (m, 3) [m].
        point: (3,) on the plane [m].
        normal: (3,) unit vector.
    """
    gap, normals = np.zeros(len(points)), np.empty((len(points), 3))
    for k in range(len(points)):
        for i in range(3):
            gap[k] += (points[k, i] - point[i]) * normal[i]
            normals[k, i] = normal[i]
    return gap, normals
