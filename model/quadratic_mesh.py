"""Quadratic tetrahedral meshes: four corners and six mid-edge nodes an element."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.arrays import Array, Ints
from tauten.model.mesh import TetMesh, oriented

EDGES = np.array([[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]])  # of corners, in VTK's order


@dataclass(frozen=True, slots=True)
class QuadraticMesh:
    """A body of quadratic tetrahedra.

    Attributes:
        nodes: (n_nodes, 3) rest positions [m], corners and mid-edge nodes.
        tets: (e, 10) node ids: four corners, then the nodes on the edges `EDGES`.
    """

    nodes: Array
    tets: Ints

    def split(self) -> TetMesh:
        """Every element cut into eight linear tetrahedra on the same nodes (Bey's red refinement)."""
        a, b, c, d, ab, bc, ac, ad, bd, cd = self.tets.T
        children = [
            (a, ab, ac, ad), (ab, b, bc, bd), (ac, bc, c, cd), (ad, bd, cd, d),
            (ab, ac, ad, bd), (ab, ac, bd, bc), (ac, ad, bd, cd), (ac, bc, cd, bd),
        ]  # fmt: skip
        tets = np.stack([np.stack(child, axis=1) for child in children], axis=1).reshape(-1, 4)
        return TetMesh(self.nodes, oriented(self.nodes, tets))


def with_midpoints(mesh: TetMesh) -> QuadraticMesh:
    """The same body as quadratic tetrahedra with straight edges."""
    edges = np.sort(mesh.tets[:, EDGES], axis=2).reshape(-1, 2)  # (6 e, 2)
    unique, inverse = np.unique(edges, axis=0, return_inverse=True)
    middle = len(mesh.nodes) + inverse.reshape(-1, 6)  # (e, 6)
    nodes = np.vstack([mesh.nodes, mesh.nodes[unique].mean(axis=1)])
    return QuadraticMesh(nodes, np.concatenate([mesh.tets, middle], axis=1))
