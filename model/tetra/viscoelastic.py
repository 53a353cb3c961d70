"""Viscous stresses of a body made of domains of integration, and the memory of its Maxwell branches.

A step of length h from the state q₀ takes (V1) (`tauten.model.materials.viscosity`) with F at q₀:

    Q_i⁺ = α_i (Q_i + g_i D (E⁺ − E)),   α_i = 1 / (1 + h / τ_i)
    f_a = −V F (Σ α_i Q_i) g_a − (C v)_a                                           (V2)

The matrix C = V Bᵀ (D_v + h Σ α_i g_i D) B, with B v = sym(Fᵀ Ḟ), is positive semidefinite, and no rigid
motion has viscous forces. When the step ends, the branches are updated with the strains of both ends.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.materials import Law, Viscosity
from tauten.model.numerics import Array, Ints, kernel
from tauten.model.tetra.domains import add_blocks, gradients_at_points
from tauten.model.tetra.solid import Solid


@dataclass(frozen=True, slots=True)
class Viscoelasticity:
    """Constants of (V2) for each law of a body.

    Attributes:
        viscous: (m, 2) λ_v and μ_v [Pa s].
        moduli: (m, b, 2) λ and μ of the branches [Pa].
        times: (m, b) relaxation times [s].
        law: (p,) law of each point of quadrature.
        volume: (p,) volume of each point [m³].
    """

    viscous: Array
    moduli: Array
    times: Array
    law: Ints
    volume: Array

    @property
    def memory_size(self) -> int:
        """Numbers of memory: six a branch and point."""
        return 6 * len(self.law) * int(self.times.shape[1])

    def branches(self, memory: Array) -> Array:
        """Stresses Q of the branches (p, b, 6) [Pa], 11, 22, 33, 23, 13, 12; of an empty memory zero."""
        shape = (len(self.law), self.times.shape[1], 6)
        return np.zeros(shape) if memory.size == 0 else memory.reshape(shape)

    def assemble(self, solid: Solid, x: Array, memory: Array, h: float) -> tuple[Array, Array]:
        """Forces of the memory (n_nodes, 3) [N], and C as values (nnz,) [N s/m].

        Args:
            solid: the body.
            x: (n_nodes, 3) positions where the step starts [m].
            memory: there.
            h: time step [s].
        """
        alpha = 1.0 / (1.0 + h / self.times)  # (m, b)
        lame = self.viscous + h * np.einsum("mb,mbk->mk", alpha, self.moduli)  # (m, 2)
        stress = np.einsum("pb,pbs->ps", alpha[self.law], self.branches(memory))  # (p, 6)
        force, blocks = np.zeros_like(x), solid.blocks.zeros()
        first = 0
        for part, slot in zip(solid.domains, solid.slots, strict=True):
            count = part.volumes.size
            arrays = (part.nodes, part.gradients, part.volumes, part.law)
            assemble_viscous(x, arrays, lame, stress[first : first + count], slot, force, blocks)
            first += count
        C = np.zeros(solid.blocks.nonzeros)
        solid.blocks.add_to(C, blocks)
        return force, C

    def remembered(
        self, solid: Solid, before: Array, after: Array, memory: Array, h: float
    ) -> Array:
        """The memory at the end of a step.

        Args:
            solid: the body.
            before: (n_nodes, 3) positions where the step starts [m].
            after: (n_nodes, 3) positions where it ends [m].
            memory: where it starts.
            h: time step [s].
        """
        if self.times.shape[1] == 0:
            return memory
        change = strains(solid, after) - strains(solid, before)  # (p, 6)
        trace = change[:, :3].sum(axis=1)
        moduli = self.moduli[self.law]  # (p, b, 2)
        stress = 2.0 * moduli[:, :, 1, None] * change[:, None, :]
        stress[:, :, :3] += (moduli[:, :, 0] * trace[:, None])[:, :, None]
        alpha = 1.0 / (1.0 + h / self.times[self.law])  # (p, b)
        updated: Array = alpha[:, :, None] * (self.branches(memory) + stress)
        return updated.ravel()

    def energy(self, memory: Array) -> float:
        """The elastic energy that the branches store, ½ V Q D⁻¹ Q [J]."""
        Q = self.branches(memory)  # (p, b, 6)
        lam, mu = np.moveaxis(self.moduli[self.law], 2, 0)  # (p, b) each
        trace = Q[:, :, :3].sum(axis=2)
        square = (Q[:, :, :3] ** 2).sum(axis=2) + 2.0 * (Q[:, :, 3:] ** 2).sum(axis=2)
        bulk = 3.0 * lam + 2.0 * mu
        mean = np.divide(trace**2, 6.0 * bulk, out=np.zeros_like(bulk), where=bulk > 0.0)
        deviator = square - trace**2 / 3.0
        shear = np.divide(deviator, 4.0 * mu, out=np.zeros_like(mu), where=mu > 0.0)
        return float(self.volume @ (mean + shear).sum(axis=1))


def make_viscoelasticity(
    solid: Solid, laws: list[Law], viscosities: list[Viscosity]
) -> Viscoelasticity:
    """Constants of a body."""
    count = max(len(item.times) for item in viscosities)
    moduli, times = np.zeros((len(laws), count, 2)), np.ones((len(laws), count))
    for index, (law, item) in enumerate(zip(laws, viscosities, strict=True)):
        for branch, (share, time) in enumerate(zip(item.shares, item.times, strict=True)):
            moduli[index, branch] = share * np.array(law.lame)
            times[index, branch] = time
    repeated = [np.repeat(part.law, part.volumes.shape[1]) for part in solid.domains]
    return Viscoelasticity(
        viscous=np.array([[item.volume, item.shear] for item in viscosities]),
        moduli=moduli,
        times=times,
        law=np.concatenate(repeated),
        volume=np.concatenate([part.volumes.ravel() for part in solid.domains]),
    )


def strains(solid: Solid, x: Array) -> Array:
    """Green strains at all points of quadrature (p, 6), shear components not doubled."""
    F = np.concatenate(
        [gradients_at_points(x, part.nodes, part.gradients) for part in solid.domains]
    )
    E = 0.5 * (np.einsum("pki,pkj->pij", F, F) - np.eye(3))
    found: Array = E[:, [0, 1, 2, 1, 0, 0], [0, 1, 2, 2, 2, 1]]
    return found


@kernel
def assemble_viscous(  # noqa: C901  one flat loop nest is what numba compiles best
    x: Array,
    domains: tuple[Ints, Array, Array, Ints],
    lame: Array,
    stress: Array,
    slot: Ints,
    force: Array,
    blocks: Array,
) -> None:
    """Add −V F S g_a to `force` (n_nodes, 3), and the viscous matrix to `blocks` (m, 9).

    With a = F g_a, b = F g_b, its blocks are V (λ a bᵀ + μ (b aᵀ + (g_a·g_b) F Fᵀ)).

    Args:
        x: (n_nodes, 3) positions [m].
        domains: nodes, gradients, volumes and law of `Domains`.
        lame: (m, 2) λ and μ of each law [Pa s].
        stress: (d p, 6) second Piola-Kirchhoff stress S at each point [Pa].
        slot: numbers of the blocks, see `assemble_domains`.
        force: output, accumulated [N].
        blocks: output, accumulated [N s/m].
    """
    nodes, gradients, volumes, law = domains
    n_nodes, n_points = nodes.shape[1], gradients.shape[1]
    all_F = gradients_at_points(x, nodes, gradients)
    FF, P = np.empty((3, 3)), np.empty((3, 3))
    a = np.empty((n_nodes, 3))
    Ke = np.empty((n_nodes, n_nodes, 3, 3))
    for e in range(nodes.shape[0]):
        lam, mu = lame[law[e], 0], lame[law[e], 1]
        Ke[:] = 0.0
        for p in range(n_points):
            V, g, point = volumes[e, p], gradients[e, p], e * n_points + p
            F, S = all_F[point], stress[point]
            for i in range(3):
                P[i, 0] = F[i, 0] * S[0] + F[i, 1] * S[5] + F[i, 2] * S[4]
                P[i, 1] = F[i, 0] * S[5] + F[i, 1] * S[1] + F[i, 2] * S[3]
                P[i, 2] = F[i, 0] * S[4] + F[i, 1] * S[3] + F[i, 2] * S[2]
                for j in range(3):
                    FF[i, j] = F[i, 0] * F[j, 0] + F[i, 1] * F[j, 1] + F[i, 2] * F[j, 2]
            for n in range(n_nodes):
                for i in range(3):
                    a[n, i] = F[i, 0] * g[n, 0] + F[i, 1] * g[n, 1] + F[i, 2] * g[n, 2]
                    f = P[i, 0] * g[n, 0] + P[i, 1] * g[n, 1] + P[i, 2] * g[n, 2]
                    force[nodes[e, n], i] -= V * f
            for n in range(n_nodes):
                for m in range(n, n_nodes):
                    dot = g[n, 0] * g[m, 0] + g[n, 1] * g[m, 1] + g[n, 2] * g[m, 2]
                    for i in range(3):
                        for j in range(3):
                            shear = a[m, i] * a[n, j] + dot * FF[i, j]
                            Ke[n, m, i, j] += V * (lam * a[n, i] * a[m, j] + mu * shear)
        add_blocks(Ke, slot[e], blocks)
