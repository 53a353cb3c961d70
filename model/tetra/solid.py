"""A body's elements with their laws and their places in the pattern of its tangent."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.materials import COROTATIONAL, NO_TANGENT, Law, law_arrays
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
        n_elements: tetrahedra they are made from.
        nonzeros: entries of the tangent.
    """

    domains: tuple[Domains, ...]
    slots: tuple[tuple[Ints, Ints], ...]
    laws: tuple[Ints, Array]
    n_elements: int
    nonzeros: int

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

    def energy(self, x: Array) -> float:
        """The elastic energy at positions x (n_nodes, 3) [J]."""
        return self.assemble(x, NO_TANGENT, np.zeros_like(x), np.zeros(0))


def make_solid(domains: list[Domains], laws: list[Law], pattern: Pattern, n_elements: int) -> Solid:
    """Place domains in a pattern that couples the nodes of each of them.

    Args:
        domains: the domains, one entry for each shape.
        laws: what their `law` points to.
        pattern: sparsity of the tangent.
        n_elements: tetrahedra they are made from.
    """
    return Solid(
        domains=tuple(domains),
        slots=tuple(pattern.blocks(part.nodes) for part in domains),
        laws=law_arrays(laws),
        n_elements=n_elements,
        nonzeros=len(pattern.indices),
    )


def linear_energy(
    x: Array, tets: Ints, gradients: Array, volumes: Array, lame: tuple[float, float]
) -> float:
    """The elastic energy of linear corotational tetrahedra [J]; arguments as in `assemble`.

    Args:
        x: (n_nodes, 3) positions [m].
        tets: (e, 4) corners.
        gradients: (e, 4, 3) at rest [1/m].
        volumes: (e,) at rest [m³].
        lame: (λ, μ) [Pa].
    """
    none = np.zeros((len(tets), 4, 4), dtype=np.int64)
    first = np.zeros(len(tets), dtype=np.int64)
    laws = (np.array([COROTATIONAL]), np.array([[*lame, 0.0, 0.0, 0.0]]))
    domains = (tets, gradients[:, None], volumes[:, None], first)
    slots = (none, none[:, 0])
    return assemble_domains(x, domains, laws, NO_TANGENT, slots, np.zeros_like(x), np.zeros(0))
