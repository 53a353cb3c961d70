"""A body's elements with their laws and their places in the pattern of its tangent."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.materials import (
    COROTATIONAL,
    MATERIAL,
    N_CONSTANTS,
    NO_TANGENT,
    PROJECTED,
    Law,
    law_arrays,
)
from tauten.model.numerics import Array, Ints
from tauten.model.system import Pattern
from tauten.model.tetra.blocks import LowerBlocks, lower_blocks
from tauten.model.tetra.corotational import assemble_corotational
from tauten.model.tetra.domains import Domains, assemble_domains


@dataclass(frozen=True, slots=True)
class Solid:
    """Domains of integration that make up a body; made by `make_solid`.

    Attributes:
        domains: the domains, one entry for each shape, the nodes of each domain ascending.
        slots: numbers of each domain's blocks, see `lower_blocks`.
        blocks: the blocks of the tangent.
        laws: kinds (m,) and constants (m, 7) that the domains' `law` points to.
        stiffness: V λ and V μ (d, 2) [N m] of the domains of each shape where all laws are corotational and
            domains have one point; None elsewhere.
        n_elements: tetrahedra they are made from.
    """

    domains: tuple[Domains, ...]
    slots: tuple[Ints, ...]
    blocks: LowerBlocks
    laws: tuple[Ints, Array]
    stiffness: tuple[Array, ...] | None
    n_elements: int

    def assemble(
        self, x: Array, tangent: int, force: Array, K: Array, D: Array | None = None
    ) -> float:
        """Add internal forces to `force` (n_nodes, 3) and tangents to the CSC values `K` and `D` (nnz,).

        Args:
            x: (n_nodes, 3) positions [m].
            tangent: NO_TANGENT, EXACT, PROJECTED or MATERIAL.
            force: output [N].
            K: output [N/m]; left alone without tangent.
            D: output: the tangent MATERIAL in the same pass [N/m]; None: it is not wanted.

        Returns:
            The elastic energy [J].
        """
        energy, blocks = 0.0, self.blocks.zeros()
        material = blocks[:0] if D is None else np.zeros_like(blocks)
        for index, (part, slot) in enumerate(zip(self.domains, self.slots, strict=True)):
            if self.stiffness is not None:
                elements = (part.nodes, part.gradients[:, 0], self.stiffness[index])
                energy += assemble_corotational(x, elements, tangent, slot, force, blocks, material)
            else:
                arrays = (part.nodes, part.gradients, part.volumes, part.law)
                energy += assemble_domains(
                    x, arrays, self.laws, tangent, slot, force, blocks, material
                )
        if tangent != NO_TANGENT:
            self.blocks.add_to(K, blocks)
        if D is not None:
            self.blocks.add_to(D, material)
        return energy

    def energy(self, x: Array) -> float:
        """The elastic energy at positions x (n_nodes, 3) [J]."""
        return self.assemble(x, NO_TANGENT, np.zeros_like(x), np.zeros(0))

    @property
    def is_plain(self) -> bool:
        """Whether it is made of linear corotational tetrahedra of one law."""
        shapes = [part.gradients.shape[1:3] for part in self.domains]
        return shapes == [(1, 4)] and self.stiffness is not None and len(self.laws[0]) == 1

    @property
    def semidefinite(self) -> int:
        """The tangent near the exact one that is positive semidefinite at any deformation."""
        return MATERIAL if self.is_plain else PROJECTED


def make_solid(domains: list[Domains], laws: list[Law], pattern: Pattern, n_elements: int) -> Solid:
    """Place domains in a pattern that couples the nodes of each of them."""
    parts = tuple(part.ascending() for part in domains)
    blocks, slots = lower_blocks(pattern, [part.nodes for part in parts])
    kinds, constants = law_arrays(laws)
    one_point = all(part.volumes.shape[1] == 1 for part in parts)
    stiffness = None
    if one_point and (kinds == COROTATIONAL).all():
        stiffness = tuple(part.volumes * constants[part.law, N_CONSTANTS:] for part in parts)
    return Solid(parts, slots, blocks, (kinds, constants), stiffness, n_elements)
