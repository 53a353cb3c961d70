"""Integration points of a body of tetrahedra: the elements that a sample is taken from.

The force of a body is a sum over integration points, each with a volume, gradients of shape functions and a
law. Linear tetrahedra have one each, quadratic ones four; a smoothed body has one for each of its domains.
Modules of this folder call them elements, as the literature on sampling does.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.numerics import Array, Ints
from tauten.model.tetra import Domains, Tetrahedra


@dataclass(frozen=True, slots=True, eq=False)
class IntegrationPoints:
    """Integration points of a body, domain by domain.

    Attributes:
        domains: domains of the body, one entry for each shape.
        volume: (p,) volume of each point at rest [m³].
        kind: (p,) density of each point's law, see `tauten.model.materials`.
        constants: (p, 7) constants of its law, λ and μ [Pa].
    """

    domains: tuple[Domains, ...]
    volume: Array
    kind: Ints
    constants: Array

    def __len__(self) -> int:
        return len(self.volume)


def integration_points(tetrahedra: Tetrahedra) -> IntegrationPoints:
    """The integration points of a body."""
    domains, (kinds, constants) = tetrahedra.elements.domains, tetrahedra.elements.laws
    law = np.concatenate([np.repeat(part.law, part.volumes.shape[1]) for part in domains])
    return IntegrationPoints(
        domains=domains,
        volume=np.concatenate([part.volumes.ravel() for part in domains]),
        kind=np.ascontiguousarray(kinds[law]),
        constants=np.ascontiguousarray(constants[law]),
    )


def node_rows(tetrahedra: Tetrahedra, Phi: Array, nodes: Ints) -> Array:
    """Rows (…, 3, r) of Φ that belong to nodes, zero where a node is fixed.

    Args:
        tetrahedra: of the full model.
        Phi: (n, r) state modes.
        nodes: (…,) node numbers.
    """
    first = tetrahedra.dof[nodes]
    rows = Phi[np.maximum(first, 0)[..., None] + np.arange(3)]
    return np.where((first >= 0)[..., None, None], rows, 0.0)


def gradients_of(
    tetrahedra: Tetrahedra, points: IntegrationPoints, Phi: Array, chosen: Ints
) -> Array:
    """Derivatives (9 s, r) of the deformation gradients F_ij by α [1/m], row 9 e + 3 i + j.

    Args:
        tetrahedra: of the full model.
        points: all of its integration points.
        Phi: (n, r) state modes.
        chosen: (s,) numbers of the points, ascending.
    """
    G = np.empty((len(chosen), 3, 3, Phi.shape[1]))
    first = 0
    for part in points.domains:
        inside = (chosen >= first) & (chosen < first + part.volumes.size)
        domain, point = np.divmod(chosen[inside] - first, part.volumes.shape[1])
        rows = node_rows(tetrahedra, Phi, part.nodes[domain])  # (k, nodes, 3, r)
        gradients = part.gradients[domain, point]  # (k, nodes, 3)
        G[inside] = np.einsum("sair,saj->sijr", rows, gradients, optimize=True)
        first += part.volumes.size
    return G.reshape(-1, Phi.shape[1])
