"""Whether a body or an obstacle may pass between the candidates of a contact."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np

from tauten.model.contact.pair import ContactPair
from tauten.model.contact.shapes import PlaneShape
from tauten.model.mesh import largest_hole
from tauten.model.numerics import Array, Ints

LARGEST_HOLE = 0.5  # of the width of what may touch, distance of a place from a candidate
TINY = 1e-12  # m


def holes_between(
    pairs: Sequence[tuple[ContactPair, Ints]], vertices: Array, body: Ints
) -> Iterator[str]:
    """Contacts of bodies of which one may fall between the candidates of the other one, in words.

    A body is as wide as the middle one of its extents. Of a contact in both directions one is enough.

    Args:
        pairs: contacts, those of loose bodies among them, and triangles (t, 3) of that with the candidates.
        vertices: (v, 3) of the surfaces at rest [m].
        body: (v,) number of the body that each vertex belongs to.
    """
    found = dict[tuple[int, int], tuple[float, str]]()
    for pair, own in pairs:
        if not pair.loose:
            continue
        points, owner = pair.candidates(vertices), body[own[:, 0]]
        target = body[pair.triangles[:, 0]]
        for one, other in product(np.unique(owner).tolist(), np.unique(target).tolist()):
            near = body[pair.nodes[:, 0]] == one
            if one == other or not near.any():
                continue
            hole = largest_hole(vertices, own[owner == one], points[near])
            width = middle_extent(vertices[np.unique(pair.triangles[target == other])])
            key, ratio = (min(one, other), max(one, other)), hole / max(width, TINY)
            if key not in found or ratio < found[key][0]:
                found[key] = ratio, said(pair, hole, width)
    yield from (note for ratio, note in found.values() if ratio > LARGEST_HOLE)


def holes_before_obstacles(
    pairs: Sequence[tuple[ContactPair, Ints]], vertices: Array
) -> Iterator[str]:
    """Contacts with obstacles that may pass between the candidates of the robot, see `holes_between`."""
    for pair, own in pairs:
        obstacle = pair.obstacle
        if obstacle is None or isinstance(obstacle.shape, PlaneShape):
            continue
        outline, _ = obstacle.outline(obstacle.start, obstacle.start.position, 0.0)
        if len(outline) == 0:
            continue
        hole = largest_hole(vertices, own, pair.candidates(vertices))
        width = middle_extent(outline)
        if hole > LARGEST_HOLE * width:
            yield said(pair, hole, width)


def said(pair: ContactPair, hole: float, width: float) -> str:
    """What is said of a contact.

    Args:
        pair: its name.
        hole: distance of a place of the surface from a candidate [m].
        width: of what may touch [m].
    """
    return (
        f"{pair.name}: places of the surface are up to {1e3 * hole:.3g} mm from a candidate, and "
        f"what it may touch is {1e3 * width:.3g} mm wide: it may fall between them or slip off; "
        f"give spacing = {0.25 * width:.2g}"
    )


def middle_extent(points: Array) -> float:
    """The middle one of the extents of points (p, 3) along their principal axes or the coordinates [m].

    Principal axes are no directions of their own where a body is as wide as it is high.
    """
    away = points - points.mean(axis=0)
    axes = np.linalg.svd(away, full_matrices=False)[2]
    extents = [np.sort(np.ptp(x, axis=0))[1] for x in (away, away @ axes.T)]
    return float(min(extents))
