"""Rest data of linear tetrahedra: gradients of the shape functions, and masses."""

from __future__ import annotations

import numpy as np

from tauten.model.mesh import TetMesh
from tauten.model.numerics import Array


def rest_gradients(mesh: TetMesh) -> Array:
    """Gradients of the four shape functions of each element at rest: (e, 4, 3) [1/m]."""
    corners = mesh.nodes[mesh.tets]  # (e, 4, 3)
    inverse = np.linalg.inv(np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2))  # (e, 3, 3)
    g0 = -inverse.sum(axis=1, keepdims=True)
    return np.ascontiguousarray(np.concatenate([g0, inverse], axis=1))


def lumped_mass(mesh: TetMesh, density: float | Array) -> Array:
    """Nodal masses, with a quarter of every element's mass at each corner: (n_nodes,) [kg].

    Args:
        mesh: the body.
        density: of all elements, or of each (e,) [kg/m³].
    """
    share = np.repeat(density * mesh.volumes / 4.0, 4)
    return np.bincount(mesh.tets.ravel(), share, len(mesh.nodes)).astype(float)
