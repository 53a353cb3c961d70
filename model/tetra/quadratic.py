"""Quadratic tetrahedra: shape functions, four-point quadrature, lumped mass."""

from __future__ import annotations

import numpy as np

from tauten.model.mesh import EDGES, MeshError, QuadraticMesh
from tauten.model.numerics import Array, Ints
from tauten.model.tetra.domains import Domains

# Points of the rule of degree 2, in barycentric coordinates: (4, 4)
NEAR, FAR = (5.0 + 3.0 * np.sqrt(5.0)) / 20.0, (5.0 - np.sqrt(5.0)) / 20.0
POINTS = FAR + (NEAR - FAR) * np.eye(4)
# Shares of an element's mass: diagonal of the consistent mass matrix, scaled to the whole mass (Hinton, Rock
# and Zienkiewicz, Earthquake Engineering and Structural Dynamics 4, 1976); row sums are negative at corners
SHARES = np.array([1.0 / 36.0] * 4 + [4.0 / 27.0] * 6)


def shape_derivatives(L: Array) -> Array:
    """Derivatives of the ten shape functions by the barycentric coordinates L (m, 4): (m, 10, 4)."""
    derivatives = np.zeros((len(L), 10, 4))
    for a in range(4):
        derivatives[:, a, a] = 4.0 * L[:, a] - 1.0
    for a, (i, j) in enumerate(EDGES, start=4):
        derivatives[:, a, i] = 4.0 * L[:, j]
        derivatives[:, a, j] = 4.0 * L[:, i]
    return derivatives


def quadratic_domains(mesh: QuadraticMesh, law: Ints) -> Domains:
    """Gradients and volumes of quadratic tetrahedra with laws (e,), also of ones with curved edges.

    Raises:
        MeshError: an element is folded over at a point of quadrature.
    """
    by_L = shape_derivatives(POINTS)  # (p, 10, 4)
    by_xi = by_L[:, :, 1:] - by_L[:, :, :1]  # (p, 10, 3), L₀ = 1 − ξ₁ − ξ₂ − ξ₃
    jacobian = np.einsum("eai,pak->epik", mesh.nodes[mesh.tets], by_xi)  # (e, p, 3, 3)
    volumes = np.linalg.det(jacobian) / 24.0
    folded = np.flatnonzero((volumes <= 0.0).any(axis=1))
    if len(folded):
        raise MeshError(
            f"{len(folded)} quadratic tetrahedra are folded over by their mid-edge nodes, the first is "
            f"{folded[0]}; straighten its edges"
        )
    gradients = np.einsum("pak,epki->epai", by_xi, np.linalg.inv(jacobian))
    return Domains(mesh.tets, np.ascontiguousarray(gradients), volumes, law)


def quadratic_lumped_mass(domains: Domains, density: Array, n_nodes: int) -> Array:
    """A positive share of every element's mass on each of its nodes: (n_nodes,) [kg].

    Args:
        domains: quadratic tetrahedra.
        density: (e,) [kg/m³].
        n_nodes: nodes of the mesh.
    """
    mass = density * domains.volumes.sum(axis=1)  # (e,)
    shares = np.outer(mass, SHARES).ravel()
    return np.bincount(domains.nodes.ravel(), shares, n_nodes).astype(float)
