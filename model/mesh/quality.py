"""What can be wrong with a tetrahedral mesh: badly shaped elements, thin walls."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tauten.model.mesh.mesh_files import MeshError, kinds_of, read_with_meshio
from tauten.model.mesh.surface import area_normals
from tauten.model.mesh.tet_mesh import EDGES, TetMesh, used_nodes
from tauten.model.numerics import Array, Ints

PARALLEL = 1e-9  # of a triangle's edges: rays whose determinant is smaller do not cross it


def read_unchecked_mesh(path: Path, length_unit: str = "m") -> TetMesh:
    """Read tetrahedra in "m", "cm" or "mm" as they are in the file, of quadratic ones the corners.

    Raises:
        MeshError: the file is not readable, holds no tetrahedra, or corners that are no nodes.
    """
    raw = read_with_meshio(path)
    kinds = kinds_of(raw)
    kind = "tetra10" if "tetra10" in kinds else "tetra"
    if kind not in kinds:
        raise MeshError(f"{path}: no tetrahedra found; mesh the volume")
    nodes, cells, _, _ = used_nodes(raw, kind, length_unit, path)
    used, numbers = np.unique(cells[:, :4], return_inverse=True)
    return TetMesh(nodes[used], numbers.reshape(-1, 4))


def off_a_line(points: Array, short: float) -> bool:
    """Whether three of the points (p, 3) are not on a line, but for a distance `short` [m]."""
    return len(points) > 2 and bool(np.linalg.matrix_rank(points - points[0], tol=short) >= 2)


def mean_ratios(mesh: TetMesh) -> Array:
    """Mean ratio of each tetrahedron, 12 (3 V)^(2/3) / Σ l²: (e,).

    It is 1 for a regular tetrahedron, 0 for a flat one and negative for an inverted one (Liu and Joe 1994).
    """
    edges = mesh.nodes[mesh.tets[:, EDGES[:, 1]]] - mesh.nodes[mesh.tets[:, EDGES[:, 0]]]
    squares = np.einsum("eki,eki->e", edges, edges)  # (e,) sum over six edges
    volumes = 3.0 * mesh.volumes
    signed = 12.0 * np.cbrt(volumes) * np.abs(np.cbrt(volumes))
    ratios: Array = signed / np.maximum(squares, np.finfo(float).tiny)
    return ratios


def ray_crossings(start: Array, direction: Array, corners: Array) -> tuple[Array, Array, Array]:
    """Where rays cross the planes of triangles (Möller and Trumbore 1997).

    Args:
        start: (3,) or (t, 3) of the rays [m].
        direction: (3,) or (t, 3) of the rays, of any length.
        corners: (t, 3, 3) of the triangles [m].

    Returns:
        (t,) weights of the second and of the third corner, and the way along the ray, in lengths of its
        direction; NaN where it is parallel to the plane.
    """
    edge1, edge2 = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    away, p = start - corners[:, 0], np.cross(direction, edge2)
    q = np.cross(away, edge1)
    with np.errstate(all="ignore"):
        products = np.stack([away * p, q * direction, edge2 * q]).sum(axis=2)  # (3, t)
        found = products / (edge1 * p).sum(axis=1)
    u, v, t = np.where(np.isfinite(found), found, np.nan)
    return u, v, t


def wall_thickness(vertices: Array, boundary: Ints, triangles: Ints) -> Array:
    """Distances (t,) from the centres of triangles straight into the body to its other side, or inf [m].

    Args:
        vertices: (v, 3) positions [m].
        boundary: (b, 3) vertex ids of the whole surface, seen from outside counter-clockwise.
        triangles: (t, 3) those to measure at.
    """
    surface = vertices[boundary]  # (b, 3, 3)
    outward = area_normals(surface)
    chosen = vertices[triangles]  # (t, 3, 3)
    thickness = np.full(len(triangles), np.inf)
    for index, (corners, normal) in enumerate(zip(chosen, area_normals(chosen), strict=True)):
        direction = -normal / np.linalg.norm(normal)
        # only triangles that the ray leaves through
        leaving = outward @ direction > PARALLEL * np.linalg.norm(outward, axis=1)
        u, v, t = ray_crossings(corners.mean(axis=0), direction, surface[leaving])
        crossed = (u >= -1e-9) & (v >= -1e-9) & (u + v <= 1.0 + 1e-9) & (t > 0.0)
        thickness[index] = t[crossed].min(initial=np.inf)
    return thickness
