"""Triangles of simple shapes, for drawing them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.numerics import Array, Ints

_AROUND, _HALF = 24, 6  # pieces around an axis, and from a pole to the equator
_BOX = np.array([
    [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
    [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3],
])  # fmt: skip


@dataclass(frozen=True, slots=True)
class RodOutline:
    """A rod, or a ball: what its triangles are made from.

    Attributes:
        start: (3,) centre of one end [m].
        along: (3,) from there to the centre of the other [m]; zero: a ball.
        radius: [m].
        flat: whether the ends are flat instead of round.
    """

    start: Array
    along: Array
    radius: float
    flat: bool = False

    def triangles(self) -> tuple[Array, Ints]:
        """Vertices (v, 3) [m] and triangles (t, 3)."""
        if self.flat:
            half = 0.5 * self.along
            return cylinder(self.start + half, half, self.radius)
        return rod(self.start, self.along, self.radius)


def square(centre: Array, normal: Array, side: float) -> tuple[Array, Ints]:
    """A square: vertices (4, 3) [m] and triangles (2, 3).

    Args:
        centre: (3,) of it [m].
        normal: (3,) unit vector at right angles to it.
        side: its length [m].
    """
    u, v = (0.5 * side * one for one in across(normal))
    corners = centre + np.array([-u - v, u - v, u + v, v - u])
    return corners, np.array([[0, 1, 2], [0, 2, 3]])


def box(lower: Array, upper: Array) -> tuple[Array, Ints]:
    """A box along the axes, from its lower to its upper corner [m]: vertices (8, 3) and triangles (12, 3)."""
    high = np.indices((2, 2, 2)).reshape(3, -1).T == 1  # (8, 3)
    return np.where(high, upper, lower), _BOX.copy()


def rod(start: Array, along: Array, radius: float) -> tuple[Array, Ints]:
    """A rod with round ends, or a ball: vertices (v, 3) [m] and triangles (t, 3).

    Args:
        start: (3,) centre of one end [m].
        along: (3,) from there to the centre of the other [m]; zero: a ball.
        radius: [m].
    """
    length = float(np.linalg.norm(along))
    axis = along / length if length > 0.0 else np.array([0.0, 0.0, 1.0])
    u, v = across(axis)
    polar = np.linspace(0.0, np.pi, 2 * _HALF + 1)
    polar = np.concatenate(
        [polar[: _HALF + 1], polar[_HALF:]]
    )  # the equator twice, once for each end
    turn = np.linspace(0.0, 2.0 * np.pi, _AROUND, endpoint=False)
    rim = np.outer(np.cos(turn), u) + np.outer(np.sin(turn), v)  # (_AROUND, 3)
    rings = np.cos(polar)[:, None, None] * axis + np.sin(polar)[:, None, None] * rim
    ends = np.where(np.arange(len(polar))[:, None, None] <= _HALF, along, 0.0)
    vertices = (start + ends + radius * rings).reshape(-1, 3)
    ring, place = np.indices((len(polar) - 1, _AROUND)).reshape(2, -1)
    here, beside = ring * _AROUND + place, ring * _AROUND + (place + 1) % _AROUND
    below, diagonal = here + _AROUND, beside + _AROUND
    first, second = np.stack([here, below, beside], 1), np.stack([beside, below, diagonal], 1)
    return vertices, np.concatenate([first, second])


def cylinder(centre: Array, half: Array, radius: float) -> tuple[Array, Ints]:
    """A rod with flat ends: vertices (v, 3) [m] and triangles (t, 3).

    Args:
        centre: (3,) of it [m].
        half: (3,) from there to the centre of one end [m].
        radius: [m].
    """
    u, v = across(half / np.linalg.norm(half))
    turn = np.linspace(0.0, 2.0 * np.pi, _AROUND, endpoint=False)
    rim = radius * (np.outer(np.cos(turn), u) + np.outer(np.sin(turn), v))  # (_AROUND, 3)
    vertices = centre + np.concatenate([rim - half, rim + half, [-half, half]])
    here = np.arange(_AROUND)
    beside, bottom, top = (here + 1) % _AROUND, np.full_like(here, 2 * _AROUND), 2 * _AROUND + 1
    faces = [
        (here, beside, _AROUND + here), (beside, _AROUND + beside, _AROUND + here),
        (bottom, beside, here), (np.full_like(here, top), _AROUND + here, _AROUND + beside),
    ]  # fmt: skip
    return vertices, np.concatenate([np.stack(face, axis=1) for face in faces])


def across(axis: Array) -> tuple[Array, Array]:
    """Two unit vectors (3,) at right angles to a unit vector (3,) and to each other, right-handed with it."""
    u = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    u /= np.linalg.norm(u)
    return u, np.cross(axis, u)
