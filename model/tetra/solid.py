"""A body's elements with their laws and their places in the pattern of its tangent."""

from __future__ import annotations

from dataclasses import dataclass

from tauten.model.materials import Law, law_arrays
from tauten.model.numerics import Array, Ints
from tauten.model.system import Pattern
from tauten.model.tetra.domains import Domains, assemble_domains


@dataclass(frozen=True, slots=True)
class Solid:
    """Domains of integration that make up a body; made by `make_solid`.

    Attributes:
        domains: the domains, one entry for each shape.
        slots: place of each domain's blocks in the tangent, see `Pattern.blocks`.
        laws: kinds (m,) and constants (m, 5) that the domains' `law` points to.
    """

    domains: tuple[Domains, ...]
    slots: tuple[tuple[Ints, Ints], ...]
    laws: tuple[Ints, Array]

    def assemble(self, x: Array, tangent: int, force: Array, K: Array) -> float:
        """Add internal forces to `force` (n_nodes, 3) and the tangent to the CSC values `K` (nnz,).

        Args:
            x: (n_nodes, 3) positions [m].
            tangent: NO_TANGENT, EXACT or PROJECTED.
            force: output [N].
            K: output [N/m]; left alone without tangent.

        Returns:
            The elastic energy [J].
        """
        energy = 0.0
        for part, slots in zip(self.domains, self.slots, strict=True):
            arrays = (part.nodes, part.gradients, part.volumes, part.law)
            energy += assemble_domains(x, arrays, self.laws, tangent, slots, force, K)
        return energy


def make_solid(domains: list[Domains], laws: list[Law], pattern: Pattern) -> Solid:
    """Place domains in a pattern that couples the nodes of each of them."""
    return Solid(
        domains=tuple(domains),
        slots=tuple(pattern.blocks(part.nodes) for part in domains),
        laws=law_arrays(laws),
    )
