"""Rows of the candidates in range: of their gaps, and across the normals where there is friction.

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
    """Contact rows H_c (m, n) with the gaps (T2), and rows across the normals where there is friction.

    Args:
        detection: candidates in range.
        placed: the vertices at this state.
        frictional: whether any pair has friction.
    """
    every = np.arange(len(detection.gap))
    normal = detection.normal[:, None]  # (m, 1, 3)
    entries = relative_motion(every, detection.coefficients, detection.vertices, normal)
    rows = placed.many_rows(Entries(*entries), detection.gap)
    if not (frictional and detection.friction.any()):
        return ContactRows(rows, detection)
    return ContactRows(rows, detection, PlacedTangents(detection, placed))


@dataclass(frozen=True, slots=True)
class PlacedTangents:
    """Rows of the relative motion across the normals; those are computed that are used.

    Attributes:
        detection: candidates in range.
        placed: the vertices at this state.
    """

    detection: Detection
    placed: Placed

    def chosen(self, rows: Ints) -> Array:
        """Two rows for each of some candidates (r,), in the order of `Contacts.tangents`: (2 r, n)."""
        found = self.detection
        directions = found.tangents(rows)  # (r, 2, 3)
        entries = relative_motion(rows, found.coefficients, found.vertices, directions)
        return dense(self.placed.rows(Entries(*entries)))


@kernel
def relative_motion(
    chosen: Ints, coefficients: Array, vertices: Ints, directions: Array
) -> tuple[Ints, Ints, Array]:
    """Motion of candidates relative to what they touch along some directions (T2), as entries over vertices.

    Args:
        chosen: (r,) some of the candidates.
        coefficients: (m, 6) of the vertices of all candidates.
        vertices: (m, 6) these vertices.
        directions: (r, d, 3) unit vectors.

    Returns:
        Starts (r d + 1,), points and vectors of `Entries`, a row for each direction.
    """
    r, d = directions.shape[0], directions.shape[1]
    starts, points = np.zeros(r * d + 1, np.int64), np.empty(6 * r * d, np.int64)
    vectors, count = np.empty((6 * r * d, 3)), 0
    for k in range(r):
        for t in range(d):
            for j in range(6):
                c = coefficients[chosen[k], j]
                if c != 0.0:
                    points[count] = vertices[chosen[k], j]
                    for i in range(3):
                        vectors[count, i] = c * directions[k, t, i]
                    count += 1
            starts[k * d + t + 1] = count
    return starts, points[:count], vectors[:count]
