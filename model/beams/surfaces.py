"""What beams carry: surfaces fixed to nodes, and the mantles of the beams themselves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from tauten.model.beams.body import BeamBody
from tauten.model.beams.profile import Profile
from tauten.model.numerics import Ints
from tauten.model.points import AttachedPoints, carry, carry_along, join_attached_points
from tauten.model.schema import Structure


@dataclass(frozen=True, slots=True)
class BeamSurfaces:
    """What the beams carry.

    Attributes:
        skin: points that contact pairs name.
        drawn: points that `triangles` join, the skin's first.
        triangles: (t, 3) of the drawn surface.
        lever: largest distance of a carried point from its node [m].
    """

    skin: AttachedPoints
    drawn: AttachedPoints
    triangles: Ints
    lever: float


def build_beam_surfaces(
    structure: Structure, profiles: list[Profile], body: BeamBody
) -> tuple[BeamSurfaces, dict[str, Ints]]:
    """AttachedPoints surfaces and the beams' own outlines; triangles of each named surface."""
    parts, named, first = [], {}, 0
    for surface in structure.surfaces:
        parts.append(carry(body.nodes, np.array(surface.nodes), np.array(surface.points)))
        named[surface.name] = np.array(surface.triangles, dtype=np.int64) + first
        first += len(surface.points)
    skin = (
        join_attached_points(parts)
        if parts
        else carry(body.nodes, np.zeros(0, dtype=np.int64), np.zeros((0, 3)))
    )
    outlines, triangles = [], list(named.values())
    for k, profile in enumerate(profiles):
        part, corners = outline(body, k, profile)
        outlines.append(part)
        triangles.append(corners + first)
        first += len(part)
    drawn = join_attached_points([skin, *outlines])
    lever = float(np.linalg.norm(drawn.offsets * drawn.weights[:, :, None], axis=2).max())
    return BeamSurfaces(skin, drawn, np.concatenate(triangles), lever), named


def outline(body: BeamBody, k: int, profile: Profile) -> tuple[AttachedPoints, Ints]:
    """The mantle of a beam, carried along it, and its triangles."""
    a, b = body.ends[k]
    frame = Rotation.from_quat(np.roll(body.axes[k], -1)).as_matrix()  # columns are the axes
    ring = profile.outline @ frame[:, 1:].T  # (c, 3)
    count = len(ring)
    points = np.concatenate([body.nodes[a] + ring, body.nodes[b] + ring])
    share = np.repeat([0.0, 1.0], count)
    i = np.arange(count)
    j = (i + 1) % count
    triangles = np.concatenate(
        [np.stack([i, j, j + count], axis=1), np.stack([i, j + count, i + count], axis=1)]
    )
    return carry_along(body.nodes, np.tile([a, b], (2 * count, 1)), share, points), triangles
