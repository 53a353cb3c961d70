"""Quadratic tetrahedral meshes: four corners and six mid-edge nodes an element."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tauten.model.mesh.groups import CellGroup, NodeNumbers
from tauten.model.mesh.mesh_files import MeshError, kinds_of, read_with_meshio
from tauten.model.mesh.surface import FACES
from tauten.model.mesh.tet_mesh import (
    EDGES,
    TetMesh,
    checked,
    eight_parts,
    read_mesh,
    used_nodes,
    with_midpoints,
)
from tauten.model.numerics import Array, Ints, row_keys


@dataclass(frozen=True, slots=True)
class QuadraticMesh:
    """A body of quadratic tetrahedra.

    Attributes:
        nodes: (n_nodes, 3) rest positions [m], corners and mid-edge nodes.
        tets: (e, 10) node ids: four corners, then the nodes on the edges `EDGES`.
        groups: cells that the mesh file names, triangles by their corners.
        numbers: of the nodes in the file; None: there is none.
    """

    nodes: Array
    tets: Ints
    groups: tuple[CellGroup, ...] = ()
    numbers: NodeNumbers | None = None

    @property
    def corners(self) -> TetMesh:
        """The elements without their mid-edge nodes, on the same nodes."""
        return TetMesh(self.nodes, self.tets[:, :4], self.groups, self.numbers)

    def split(self) -> TetMesh:
        """Every element cut into eight linear tetrahedra on the same nodes."""
        return eight_parts(self.nodes, self.tets, self.groups, self.numbers)

    def refine(self) -> QuadraticMesh:
        """Every element cut into eight quadratic ones, whose own edges are straight."""
        return quadratic_mesh(self.split())


def quadratic_mesh(mesh: TetMesh) -> QuadraticMesh:
    """The same body as quadratic tetrahedra with straight edges."""
    nodes, tets, ends = with_midpoints(mesh.nodes, mesh.tets)
    numbers = mesh.numbers and mesh.numbers.with_middles(ends)
    return QuadraticMesh(nodes, tets, mesh.groups, numbers)


def read_quadratic_mesh(
    path: Path, length_unit: str = "m", overlaps: bool = False
) -> QuadraticMesh:
    """Read quadratic tetrahedra, or linear ones and add the midpoints of their edges.

    Raises:
        MeshError: linear and quadratic tetrahedra in one file, two mid-edge nodes on one edge, or one of the
            reasons of `read_mesh`.
    """
    raw = read_with_meshio(path)
    kinds = kinds_of(raw)
    if "tetra10" not in kinds:
        return quadratic_mesh(read_mesh(path, length_unit, overlaps))
    if "tetra" in kinds:
        count = {
            kind: sum(len(block.data) for block in raw.cells if block.type == kind)
            for kind in ("tetra", "tetra10")
        }
        raise MeshError(
            f"{path}: {count['tetra']} linear beside {count['tetra10']} quadratic tetrahedra; "
            "write all of the volume with elements of second order"
        )
    nodes, tets, groups, numbers_in_file = used_nodes(raw, "tetra10", length_unit, path)
    require_shared_midpoints(tets, str(path))
    used, numbers = np.unique(tets[:, :4], return_inverse=True)
    numbers = numbers.reshape(-1, 4)
    corners = checked(nodes[used], numbers, str(path), overlaps)
    if not np.array_equal(corners.tets, numbers):  # turned round: corners 1 and 2 swapped
        tets = tets[:, [0, 2, 1, 3, 6, 5, 4, 7, 9, 8]]
    return QuadraticMesh(nodes, tets, groups, numbers_in_file)


def require_shared_midpoints(tets: Ints, source: str) -> None:
    """Raise a MeshError when an edge of quadratic tetrahedra (e, 10) has two mid-edge nodes."""
    edges = np.sort(tets[:, EDGES], axis=2).reshape(-1, 2)  # (6 e, 2)
    unique, edge = np.unique(edges, axis=0, return_inverse=True)
    pairs = np.unique(np.stack([edge.ravel(), tets[:, 4:].ravel()], axis=1), axis=0)
    double = np.flatnonzero(np.bincount(pairs[:, 0]) > 1)
    if len(double):
        a, b = unique[double[0]]
        raise MeshError(
            f"{source}: {len(double)} edges have two mid-edge nodes, the first joins nodes {a} and {b}; "
            "merge nodes that coincide"
        )


def quadratic_faces(triangles: Ints, tets: Ints) -> Ints:
    """Faces (f, 3) of quadratic tets (e, 10) that a surface (4 f, 3) consists of, normals inwards, or none.

    The surface has four triangles a face, between corners and mid-edge nodes.
    """
    number = {frozenset(ends): i for i, ends in enumerate(EDGES.tolist())}
    edges = [
        [number[frozenset((face[i], face[i - 2]))] for i in range(3)] for face in FACES.tolist()
    ]
    corners = tets[:, FACES].reshape(-1, 3)  # (4 e, 3)
    (a, b, c), (ab, bc, ca) = corners.T, tets[:, 4 + np.array(edges)].reshape(-1, 3).T
    parts = np.array([(a, ab, ca), (b, ab, bc), (c, bc, ca), (ab, bc, ca)])  # (4, 3, 4 e)
    rows = np.concatenate([triangles, np.moveaxis(parts, 1, 2).reshape(-1, 3)])
    keys, count = row_keys(np.sort(rows, axis=1)), len(triangles)
    own = np.isin(keys[count:], keys[:count]).reshape(4, -1).all(axis=0)
    faces: Ints = corners[own][:, [0, 2, 1]]
    return faces if 4 * len(faces) == count else faces[:0]
