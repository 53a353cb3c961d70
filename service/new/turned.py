"""The directions of a part that stands obliquely in its coordinates, by its flat faces."""

from __future__ import annotations

from itertools import permutations

import numpy as np
from scipy.spatial import ConvexHull

from tauten.model.contact import across
from tauten.model.mesh import TetMesh, area_normals, boundary_triangles
from tauten.model.numerics import Array

FACES = 24  # flat faces that are looked at, the largest ones
LEAST_FACE = 0.005  # of the part's surface
ALIKE = 1e-3  # components of unit normals that are so near belong to one face
SMALLER = 0.8  # an outline along an oblique axis that is smaller by this is taken
ACROSS = 0.02  # cosine of the angle between normals of faces that are perpendicular


def part_axes(mesh: TetMesh) -> Array:
    """Three directions of a part as rows, near those of the coordinates: (3, 3).

    They are those of the coordinates, unless the outline of the part, seen along the normal of a flat face,
    is much smaller than along the longest side of its bounding box: this normal is one of them then.
    """
    longest = int(np.argmax(np.ptp(mesh.nodes, axis=0)))
    normals = flat_normals(mesh)
    outlines = [outline(mesh.nodes, normal) for normal in normals]
    limit = SMALLER * outline(mesh.nodes, np.eye(3)[longest])
    if not outlines or min(outlines) > limit:
        return np.eye(3)
    along = normals[int(np.argmin(outlines))]
    sides = normals[np.abs(normals @ along) < ACROSS]
    nearest = np.eye(3)[np.argmin(np.abs(along))]
    side = sides[0] if len(sides) else nearest
    side = side - (side @ along) * along
    side /= np.linalg.norm(side)
    axes = np.stack([along, side, np.cross(along, side)])
    order = max(permutations(range(3)), key=lambda rows: np.abs(axes[list(rows)]).trace())
    ordered: Array = axes[list(order)]
    ordered *= np.sign(ordered.diagonal())[:, None]
    if np.linalg.det(ordered) < 0.0:
        ordered[int(np.argmin(ordered.diagonal()))] *= -1.0
    return ordered


def flat_normals(mesh: TetMesh) -> Array:
    """Unit normals of the large flat faces of a part, up to their sign, the largest first: (f, 3)."""
    normals = area_normals(mesh.nodes[boundary_triangles(mesh.tets)])  # of twice the area
    areas = np.linalg.norm(normals, axis=1)
    biggest = np.take_along_axis(normals, np.abs(normals).argmax(axis=1)[:, None], axis=1)
    normals = normals * np.sign(biggest)  # both sides of a wall alike
    places = np.round(normals / areas[:, None] / ALIKE).astype(np.int64)
    _, face = np.unique(places, axis=0, return_inverse=True)
    summed = np.zeros((int(face.max()) + 1, 3))
    np.add.at(summed, face, normals)
    sizes = np.linalg.norm(summed, axis=1)
    order = np.argsort(-sizes)[:FACES]
    order = order[sizes[order] > LEAST_FACE * areas.sum()]
    found: Array = summed[order] / sizes[order, None]
    return found


def outline(nodes: Array, direction: Array) -> float:
    """Area of the convex outline of points (n, 3) seen along a unit vector (3,) [m²]."""
    return float(ConvexHull(nodes @ np.stack(across(direction), axis=1)).volume)
