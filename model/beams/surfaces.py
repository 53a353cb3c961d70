"""Surfaces of beams: points that move with their nodes, and the lateral surfaces of the beams."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from tauten.model.beams.beams import Beams
from tauten.model.beams.profile import Profile
from tauten.model.numerics import Array, Ints
from tauten.model.points import AttachedPoints, attach_between


@dataclass(frozen=True, slots=True)
class BeamSurfaces:
    """Points attached to beams, and the triangles between them.

    Attributes:
        contact_points: vertices of the surfaces that may touch, which contact pairs refer to.
        drawn_points: vertices of `triangles`.
        triangles: (t, 3) ids of drawn points.
        lever: largest distance of a point from the node it is attached to [m].
    """

    contact_points: AttachedPoints
    drawn_points: AttachedPoints
    triangles: Ints
    lever: float


def chain_surface(body: Beams, profile: Profile) -> tuple[Array, Ints]:
    """The closed surface of beams, element k from node k to node k + 1, of one cross-section.

    Around every node lies one ring, between those of the two elements that meet there.

    Returns:
        Points (b, c, 3) around the b nodes [m], and triangles (t, 3), counter-clockwise seen from outside; in
        them node k has the number k and corner i of its ring b + k c + i.
    """
    count, c = len(body.ends), len(profile.outline)
    rings = np.array([ring_of(body, k, profile) for k in range(count)])  # (e, c, 3)
    for k in range(1, count):  # axes 2 and 3 of neighbours may differ by quarter turns
        turns = [np.roll(rings[k], shift, axis=0) for shift in range(c)]
        rings[k] = min(turns, key=lambda turn: float(np.abs(turn - rings[k - 1]).sum()))
    around = np.concatenate([rings[:1], rings[:-1] + rings[1:], rings[-1:]])  # (b, c, 3)
    around *= (
        np.linalg.norm(profile.outline, axis=1).max()
        / np.linalg.norm(around, axis=2).max(axis=1)[:, None, None]
    )
    i = np.arange(c)
    j = (i + 1) % c
    ends = (count + 1) + c * np.array([0, count])
    triangles = [
        np.stack([np.zeros(c, np.int64), ends[0] + j, ends[0] + i], axis=1),
        np.stack([np.full(c, count), ends[1] + i, ends[1] + j], axis=1),
    ]
    triangles += [between_rings(count + 1 + c * k, c) for k in range(count)]
    return body.nodes[:, None] + around, np.concatenate(triangles)


def outline(body: Beams, k: int, profile: Profile) -> tuple[AttachedPoints, Ints]:
    """The lateral surface of a beam: points attached between its two nodes, and triangles (t, 3) of them."""
    a, b = body.ends[k]
    ring = ring_of(body, k, profile)
    count = len(ring)
    points = np.concatenate([body.nodes[a] + ring, body.nodes[b] + ring])
    share = np.repeat([0.0, 1.0], count)
    attached = attach_between(body.nodes, np.tile([a, b], (2 * count, 1)), share, points)
    return attached, between_rings(0, count)


def ring_of(body: Beams, k: int, profile: Profile) -> Array:
    """The outline of an element at rest, about its axis, in the axes of the world: (c, 3) [m]."""
    frame = Rotation.from_quat(np.roll(body.axes[k], -1)).as_matrix()  # columns are the axes
    ring: Array = profile.outline @ frame[:, 1:].T
    return ring


def between_rings(first: int, count: int) -> Ints:
    """Triangles (2 c, 3) between two rings of c points each, numbered one by one from `first` on."""
    i = np.arange(count)
    j = (i + 1) % count
    sides = [np.stack([i, j, j + count], axis=1), np.stack([i, j + count, i + count], axis=1)]
    return np.concatenate(sides) + first
