"""Quadratic tetrahedral meshes: four corners and six mid-edge nodes an element."""

from __future__ import annotations

from dataclasses import dataclass

from tauten.model.mesh.tet_mesh import TetMesh, eight_parts, with_midpoints
from tauten.model.numerics import Array, Ints


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
        """Every element cut into eight linear tetrahedra on the same nodes."""
        return eight_parts(self.nodes, self.tets)


def quadratic_mesh(mesh: TetMesh) -> QuadraticMesh:
    """The same body as quadratic tetrahedra with straight edges."""
    return QuadraticMesh(*with_midpoints(mesh.nodes, mesh.tets))
