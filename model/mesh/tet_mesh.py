"""Tetrahedral meshes: reading, the checks that make a mesh usable, uniform refinement."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import meshio
import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from tauten.model.numerics import Array, Ints

UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}


class MeshError(ValueError):
    """A mesh that cannot carry a robot; the text says which file and what to change."""


@dataclass(frozen=True, slots=True)
class TetMesh:
    """A body of linear tetrahedra.

    Attributes:
        nodes: (n_nodes, 3) rest positions [m].
        tets: (e, 4) node ids, positively oriented.
    """

    nodes: Array
    tets: Ints

    @property
    def volumes(self) -> Array:
        """Signed volume of every tetrahedron: (e,) [m³]."""
        return signed_volumes(self.nodes, self.tets)

    @property
    def size(self) -> float:
        """Diagonal of the bounding box [m]."""
        return float(np.linalg.norm(np.ptp(self.nodes, axis=0)))

    def refine(self) -> TetMesh:
        """Every tetrahedron cut into eight through its edge midpoints (Bey's red refinement)."""
        pairs = np.array([[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]])
        edges = np.sort(self.tets[:, pairs], axis=2).reshape(-1, 2)  # (6 e, 2)
        unique, inverse = np.unique(edges, axis=0, return_inverse=True)
        middle = (len(self.nodes) + inverse.reshape(-1, 6)).T  # (6, e)
        a, b, c, d = self.tets.T
        ab, ac, ad, bc, bd, cd = middle
        children = [
            (a, ab, ac, ad), (ab, b, bc, bd), (ac, bc, c, cd), (ad, bd, cd, d),
            (ab, ac, ad, bd), (ab, ac, bd, bc), (ac, ad, bd, cd), (ac, bc, cd, bd),
        ]  # fmt: skip
        tets = np.stack([np.stack(child, axis=1) for child in children], axis=1).reshape(-1, 4)
        nodes = np.vstack([self.nodes, self.nodes[unique].mean(axis=1)])
        return TetMesh(nodes, oriented(nodes, tets))


def signed_volumes(nodes: Array, tets: Ints) -> Array:
    """Signed volume of each tetrahedron: (e,) [m³]."""
    edges = nodes[tets[:, 1:]] - nodes[tets[:, :1]]  # (e, 3, 3)
    volumes: Array = np.linalg.det(edges) / 6.0
    return volumes


def oriented(nodes: Array, tets: Ints) -> Ints:
    """The same tetrahedra with two corners swapped where the volume is negative: (e, 4)."""
    tets = tets.copy()
    flipped = signed_volumes(nodes, tets) < 0.0
    tets[flipped] = tets[flipped][:, [0, 2, 1, 3]]
    return tets


def read_mesh(path: Path, length_unit: str = "m") -> TetMesh:
    """Read the tetrahedra of any file meshio knows (.msh, .vtk, .vtu, ...).

    Args:
        path: the mesh file.
        length_unit: unit of its coordinates, one of "m", "cm", "mm".

    Returns:
        The mesh in metres; nodes that no tetrahedron uses are dropped, other cells ignored.

    Raises:
        MeshError: unreadable file, no tetrahedra, inverted, flat or unconnected elements,
            or a size no desktop robot has (a wrong unit).
    """
    if not path.is_file():
        raise MeshError(f"{path}: no such mesh file")
    try:
        raw = meshio.read(path)
    except (Exception, SystemExit) as error:  # meshio exits on formats it does not know
        raise MeshError(
            f"{path}: not readable as a mesh ({error or type(error).__name__})"
        ) from error
    blocks = [block.data for block in raw.cells if block.type == "tetra"]
    if not blocks:
        found = sorted({block.type for block in raw.cells}) or ["nothing"]
        raise MeshError(f"{path}: no tetrahedra found, only {', '.join(found)}; mesh the volume")
    tets = np.vstack(blocks).astype(np.int64)
    used, tets = np.unique(tets, return_inverse=True)
    nodes = np.asarray(raw.points, dtype=float)[used] * UNITS[length_unit]
    return checked(nodes, tets.reshape(-1, 4), str(path))


def checked(nodes: Array, tets: Ints, source: str) -> TetMesh:
    """The mesh made of these arrays, or a MeshError that says what is wrong with it."""
    if not np.isfinite(nodes).all():
        raise MeshError(
            f"{source}: node {int(np.argwhere(~np.isfinite(nodes))[0, 0])} is not finite"
        )
    extent = float(np.ptp(nodes, axis=0).max())
    if not 1e-3 <= extent <= 10.0:
        raise MeshError(
            f"{source}: the mesh is {extent:g} m long, expected 1 mm to 10 m; check length_unit"
        )
    volumes = signed_volumes(nodes, tets)
    negative = np.flatnonzero(volumes < 0.0)
    if len(negative) == len(tets):  # the other corner convention, not an error
        return checked(nodes, oriented(nodes, tets), source)
    if len(negative):
        raise MeshError(
            f"{source}: {len(negative)} inverted tetrahedra, the first is {negative[0]}"
        )
    flat = np.flatnonzero(volumes < 1e-9 * volumes.mean())
    if len(flat):
        raise MeshError(f"{source}: {len(flat)} flat tetrahedra, the first is {flat[0]}")
    require_one_body(nodes, tets, source)
    return TetMesh(nodes, tets)


def require_one_body(nodes: Array, tets: Ints, source: str) -> None:
    """Raise a MeshError when the elements do not hang together."""
    i = np.repeat(tets[:, 0], 3)
    graph = sp.coo_array((np.ones(i.size), (i, tets[:, 1:].ravel())), shape=(len(nodes),) * 2)
    count, labels = connected_components(graph, directed=False)
    if count > 1:
        sizes = np.bincount(labels[tets[:, 0]])
        stray = np.flatnonzero(labels[tets[:, 0]] != sizes.argmax())
        raise MeshError(
            f"{source}: {count} separate bodies; {len(stray)} stray tetrahedra, "
            f"the first is {stray[0]}"
        )
