"""Rest data of tetrahedra: gradients of linear shape functions, masses, and what lumping these changes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.mesh import TetMesh
from tauten.model.numerics import Array, Bools, Ints


@dataclass(frozen=True, slots=True)
class Lumping:
    """By how much masses at the nodes have a larger second moment than the elements that they stand for.

    An element of mass m with corners at d from its centre has m / 20 Σ d dᵀ, a quarter of m at each corner
    five times as much.

    Attributes:
        nodes: (e, k) nodes of each element.
        excess: (e, 3, 3) of Σ m d dᵀ about its centre [kg m²].
    """

    nodes: Ints
    excess: Array

    def within(self, region: Ints, count: int) -> Array:
        """The excess of elements wholly in one region, (n_nodes,) or −1: (count, 3, 3) [kg m²]."""
        of, found = region[self.nodes], np.zeros((count, 3, 3))
        inside: Bools = (of[:, 0] >= 0) & (of == of[:, :1]).all(axis=1)
        np.add.at(found, of[inside, 0], self.excess[inside])
        return found


def lumping(x: Array, nodes: Ints, mass: Array, shares: Array) -> Lumping:
    """The lumping of elements, as if their edges were straight.

    Args:
        x: (n_nodes, 3) positions at rest [m].
        nodes: (e, k) of each element, its corners first.
        mass: (e,) of each element [kg].
        shares: (k,) of it on the nodes.
    """
    d = x[nodes] - x[nodes[:, :4]].mean(axis=1, keepdims=True)
    more = shares - np.where(np.arange(len(shares)) < 4, 1.0 / 20.0, 0.0)
    return Lumping(nodes, np.einsum("e,k,eki,ekj->eij", mass, more, d, d))


def rest_gradients(mesh: TetMesh) -> Array:
    """Gradients of the four shape functions of each element at rest: (e, 4, 3) [1/m]."""
    corners = mesh.nodes[mesh.tets]  # (e, 4, 3)
    inverse = np.linalg.inv(np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2))  # (e, 3, 3)
    g0 = -inverse.sum(axis=1, keepdims=True)
    return np.ascontiguousarray(np.concatenate([g0, inverse], axis=1))


def lumped_mass(mesh: TetMesh, density: float | Array) -> Array:
    """Nodal masses (n_nodes,) [kg], a quarter of an element's at each corner; one density or (e,) [kg/m³]."""
    share = np.repeat(density * mesh.volumes / 4.0, 4)
    return np.bincount(mesh.tets.ravel(), share, len(mesh.nodes)).astype(float)
