"""Elements as domains of integration: energy, nodal forces and tangent, one pass over the domains.

A domain has s nodes and p points of quadrature. At a point with volume V and gradients g_a of the shape
functions at rest,

    F = Σ x_a g_aᵀ,   energy V ψ(F),   f_a = −V P g_a,   K_ab = V (g_a)_J C_iJkL (g_b)_L

with the stress P and the tangent C of a law (`tauten.model.materials`). Linear tetrahedra have s = 4 and
p = 1, quadratic ones s = 10 and p = 4, smoothed domains p = 1 and as many nodes as the tetrahedra around an
edge, a face or a node have.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tauten.model.materials import COROTATIONAL, NO_TANGENT, WORK, response
from tauten.model.mesh import TetMesh
from tauten.model.numerics import Array, Bools, Ints, kernel, polar_rotations
from tauten.model.tetra.elements import rest_gradients


@dataclass(frozen=True, slots=True, eq=False)
class Domains:
    """Domains of one shape at rest.

    Attributes:
        nodes: (d, s) node ids.
        gradients: (d, p, s, 3) gradients of the shape functions at the points of quadrature [1/m].
        volumes: (d, p) volume of each point [m³].
        law: (d,) index of the law of each domain.
    """

    nodes: Ints
    gradients: Array
    volumes: Array
    law: Ints

    def chosen(self, rows: Ints | Bools) -> Domains:
        """Some of the domains."""
        gradients, volumes = self.gradients[rows], self.volumes[rows]
        return Domains(self.nodes[rows], gradients, volumes, self.law[rows])

    def ascending(self) -> Domains:
        """The same domains with the nodes of each in ascending order."""
        order = np.argsort(self.nodes, axis=1, kind="stable")  # (d, s)
        return replace(
            self,
            nodes=np.take_along_axis(self.nodes, order, axis=1),
            gradients=np.take_along_axis(self.gradients, order[:, None, :, None], axis=2),
        )


def deforming_domains(domains: list[Domains], carrier: Ints) -> list[Domains]:
    """Those domains that can deform; the others move as rigid bodies, without energy and forces.

    What carries each node rigidly has a number, −1: nothing does (n_nodes,).
    """
    found = []
    for part in domains:
        by = carrier[part.nodes]  # (d, s)
        rigid = (by[:, 0] >= 0) & (by == by[:, :1]).all(axis=1)
        if not rigid.all():
            found.append(part.chosen(~rigid) if rigid.any() else part)
    return found


@kernel
def gradients_at_points(x: Array, nodes: Ints, gradients: Array) -> Array:
    """F = Σ x_a g_aᵀ at all points of all domains: (d p, 3, 3).

    Args:
        x: (n_nodes, 3) positions [m].
        nodes: (d, s) nodes of the domains.
        gradients: (d, p, s, 3) at rest [1/m].
    """
    n_points = gradients.shape[1]
    F = np.zeros((nodes.shape[0] * n_points, 3, 3))
    for e in range(nodes.shape[0]):
        for p in range(n_points):
            G = F[e * n_points + p]
            for a in range(nodes.shape[1]):
                for i in range(3):
                    for j in range(3):
                        G[i, j] += x[nodes[e, a], i] * gradients[e, p, a, j]
    return F


@kernel
def assemble_domains(
    x: Array,
    domains: tuple[Ints, Array, Array, Ints],
    laws: tuple[Ints, Array],
    tangent: int,
    slot: Ints,
    force: Array,
    blocks: Array,
    material: Array,
) -> float:
    """Add internal forces to `force` (n_nodes, 3) and tangents to `blocks` and `material` (m, 9).

    Args:
        x: (n_nodes, 3) positions [m].
        domains: nodes (ascending in each domain), gradients, volumes and law of `Domains`.
        laws: kinds (m,) and constants (m, 7) of the laws.
        tangent: NO_TANGENT, EXACT, PROJECTED or MATERIAL.
        slot: (d, s (s + 1) / 2) numbers of the blocks, see `lower_blocks`; not read without tangent.
        force: (n_nodes, 3) output, accumulated [N].
        blocks: output, accumulated [N/m].
        material: output, accumulated: the tangent MATERIAL in the same pass [N/m]; without entries (0, 9): it
            is not wanted.

    Returns:
        The elastic energy [J].
    """
    nodes, gradients, volumes, law = domains
    kinds, constants = laws
    n_nodes, n_points = nodes.shape[1], gradients.shape[1]
    F = gradients_at_points(x, nodes, gradients)
    R = np.empty_like(F)
    polar_rotations(F, R)
    P, C = np.empty((3, 3)), np.empty((9, 9))
    work = np.empty(WORK)
    D = np.empty((n_nodes, 3, 9))
    Ke, De = np.empty((n_nodes, n_nodes, 3, 3)), np.empty((n_nodes, n_nodes, 3, 3))
    energy, both = 0.0, material.shape[0] > 0
    for e in range(nodes.shape[0]):
        kind, c = kinds[law[e]], constants[law[e]]
        Ke[:] = 0.0
        if both:
            De[:] = 0.0
        for p in range(n_points):
            V, g = volumes[e, p], gradients[e, p]
            point = e * n_points + p
            energy += V * response(kind, c, F[point], R[point], tangent, P, C, work)
            for a in range(n_nodes):
                for i in range(3):
                    f = P[i, 0] * g[a, 0] + P[i, 1] * g[a, 1] + P[i, 2] * g[a, 2]
                    force[nodes[e, a], i] -= V * f
            if tangent != NO_TANGENT:
                add_stiffness(V, g, C, D, Ke)
            if both:
                M = R[point] if kind == COROTATIONAL else F[point]
                add_material(V * c[5], V * c[6], g, M, D, De)
        if tangent != NO_TANGENT:
            add_blocks(Ke, slot[e], blocks)
        if both:
            add_blocks(De, slot[e], material)
    return energy


@kernel
def add_blocks(Ke: Array, slot: Ints, blocks: Array) -> None:
    """Add the blocks Ke[a, b] with b ≥ a of a domain to its blocks of the tangent.

    Args:
        Ke: (s, s, 3, 3) blocks [N/m].
        slot: (s (s + 1) / 2,) numbers of the blocks, see `lower_blocks`.
        blocks: (m, 9) output, accumulated [N/m].
    """
    pair = 0
    for a in range(Ke.shape[0]):
        for b in range(a, Ke.shape[0]):
            place = slot[pair]
            if place >= 0:
                for j in range(3):  # K_ab by rows is the block of row b and column a by columns
                    for i in range(3):
                        blocks[place, 3 * j + i] += Ke[a, b, j, i]
            pair += 1


@kernel
def add_stiffness(V: float, g: Array, C: Array, D: Array, Ke: Array) -> None:
    """Add V (g_a)_J C_iJkL (g_b)_L to the blocks Ke[a, b] with b ≥ a; D (s, 3, 9) is overwritten.

    Args:
        V: volume [m³].
        g: (s, 3) gradients at rest [1/m].
        C: (9, 9) tangent of the material [Pa].
        D: (s, 3, 9) working memory, overwritten.
        Ke: (s, s, 3, 3) blocks, accumulated [N/m].
    """
    n_nodes = g.shape[0]
    for b in range(n_nodes):
        g0, g1, g2 = V * g[b, 0], V * g[b, 1], V * g[b, 2]
        for k in range(3):
            for m in range(9):
                D[b, k, m] = C[3 * k, m] * g0 + C[3 * k + 1, m] * g1 + C[3 * k + 2, m] * g2
    for a in range(n_nodes):
        g0, g1, g2 = g[a, 0], g[a, 1], g[a, 2]
        for b in range(a, n_nodes):
            for i in range(3):
                for k in range(3):
                    entry = D[b, k, 3 * i] * g0 + D[b, k, 3 * i + 1] * g1 + D[b, k, 3 * i + 2] * g2
                    Ke[a, b, i, k] += entry


@kernel
def add_material(lam: float, mu: float, g: Array, M: Array, D: Array, Ke: Array) -> None:
    """`add_stiffness` with `material_tangent`, λ ĝ_a ĝ_bᵀ + μ (ĝ_b ĝ_aᵀ + (g_a·g_b) M Mᵀ), ĝ = M g.

    Args:
        lam: volume times λ [N m].
        mu: volume times μ [N m].
        g: (s, 3) gradients at rest [1/m].
        M: (3, 3) deformation gradient, or its rotation.
        D: (s, 3, 9) working memory, overwritten.
        Ke: (s, s, 3, 3) blocks, accumulated [N/m].
    """
    n_nodes, B = g.shape[0], np.empty((3, 3))
    for i in range(3):
        for k in range(3):
            B[i, k] = mu * (M[i, 0] * M[k, 0] + M[i, 1] * M[k, 1] + M[i, 2] * M[k, 2])
    for a in range(n_nodes):
        for i in range(3):
            D[a, 0, i] = M[i, 0] * g[a, 0] + M[i, 1] * g[a, 1] + M[i, 2] * g[a, 2]
    for a in range(n_nodes):
        for b in range(a, n_nodes):
            dot = g[a, 0] * g[b, 0] + g[a, 1] * g[b, 1] + g[a, 2] * g[b, 2]
            for i in range(3):
                along, across = lam * D[a, 0, i], mu * D[b, 0, i]
                for k in range(3):
                    Ke[a, b, i, k] += along * D[b, 0, k] + across * D[a, 0, k] + dot * B[i, k]


def linear_domains(mesh: TetMesh, law: Ints) -> Domains:
    """Linear tetrahedra, each with the law `law` (e,) points to."""
    gradients = rest_gradients(mesh)[:, None].copy()  # (e, 1, 4, 3)
    return Domains(mesh.tets, gradients, mesh.volumes[:, None].copy(), law)
