"""Rows of the candidates in range: of their gaps, and of their relative motion where there is friction.

Most candidates are vertices, and an obstacle has no vertices that move: of the six vertices that a gap may
depend on, only those with a coefficient have an entry.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.contact.detection import Detection
from tauten.model.numerics import Array, Ints, kernel
from tauten.model.points import Entries, Placed
from tauten.model.rows import ContactRows, dense


def contact_rows(detection: Detection, placed: Placed, frictional: bool = False) -> ContactRows:
    """Contact rows H_c (m, n) with the gaps (T2) of candidates in range, and with friction their motion."""
    every, normal = np.arange(len(detection.gap)), detection.normal[:, None]  # (m, 1, 3)
    rows = placed.many_rows(relative_motion(detection, every, normal), detection.gap)
    if not (frictional and detection.friction.any()):
        return ContactRows(rows, detection, frictional=frictional)
    return ContactRows(rows, detection, PlacedContacts(detection, placed), frictional)


@dataclass(frozen=True, slots=True)
class PlacedContacts:
    """Candidates in range at one state, at which the vertices are placed; a `RelativeMotion`."""

    detection: Detection
    placed: Placed

    def along(self, directions: Array, chosen: Ints) -> Array:
        """Rows of the motion of some candidates along unit directions, see `RelativeMotion`."""
        return dense(self.placed.rows(relative_motion(self.detection, chosen, directions)))


def relative_motion(detection: Detection, chosen: Ints, directions: Array) -> Entries:
    """Motion of candidates relative to what they touch along some directions (T2), as rows over vertices.

    Args:
        detection: candidates in range.
        chosen: (r,) some of them.
        directions: (r, d, 3) unit vectors, of a row each.
    """
    rows = directions.shape[0] * directions.shape[1]
    starts, points = np.empty(rows + 1, np.int64), np.empty(6 * rows, np.int64)
    vectors = np.empty((6 * rows, 3))
    moving = (detection.coefficients, detection.vertices)
    count = _relative_motion(chosen, moving, directions, starts, points, vectors)
    return Entries(starts, points[:count], vectors[:count])


@kernel
def _relative_motion(
    chosen: Ints, moving: tuple[Array, Ints], directions: Array, starts: Ints, points: Ints,
    vectors: Array,
) -> int:  # fmt: skip
    """Write `relative_motion` into its arrays; returns the number of entries.

    Args:
        chosen: (r,) some of the candidates.
        moving: (m, 6) coefficients of the vertices of all candidates, and these vertices.
        directions: (r, d, 3) unit vectors.
        starts: (r d + 1,) output.
        points: (6 r d,) output.
        vectors: (6 r d, 3) output.
    """
    coefficients, vertices = moving
    d, count = directions.shape[1], 0
    starts[0] = 0
    for k in range(directions.shape[0]):
        for t in range(d):
            for j in range(6):
                c = coefficients[chosen[k], j]
                if c != 0.0:
                    points[count] = vertices[chosen[k], j]
                    for i in range(3):
                        vectors[count, i] = c * directions[k, t, i]
                    count += 1
            starts[k * d + t + 1] = count
    return count
