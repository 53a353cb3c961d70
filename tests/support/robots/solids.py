"""Bodies of any element and law that are held, loaded and brought to equilibrium, for tests."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from tauten.model.materials import EXACT, NO_TANGENT, PROJECTED, Law
from tauten.model.mesh import (
    QuadraticMesh,
    TetMesh,
    boundary_triangles,
    quadratic_mesh,
    triangle_areas,
)
from tauten.model.numerics import Array, Bools, Ints
from tauten.model.system import Pattern, make_pattern
from tauten.model.tetra import (
    Domains,
    Solid,
    linear_domains,
    make_solid,
    quadratic_domains,
    smoothed_domains,
)

Kind = Literal["linear", "quadratic", "edge", "node", "edge-node"]


@dataclass(frozen=True, slots=True)
class Body:
    """A body at rest, its fixed nodes, its elements.

    Attributes:
        mesh: linear tetrahedra on all nodes, also of quadratic elements.
        fixed: (n_nodes,) nodes that do not move.
        pattern: sparsity of the tangent.
        solid: the elements.
    """

    mesh: TetMesh
    fixed: Bools
    pattern: Pattern
    solid: Solid

    def forces(self, x: Array, tangent: int = EXACT) -> tuple[float, Array, sp.csc_array]:
        """Energy [J], internal forces of all nodes (n_nodes, 3) [N], tangent of the free ones."""
        f, K = np.zeros_like(x), np.zeros(len(self.pattern.indices))
        energy = self.solid.assemble(x, tangent, f, K)
        return energy, f, sp.csc_array((K, self.pattern.indices, self.pattern.indptr))

    def equilibrium(self, load: Array, start: Array | None = None) -> tuple[Array, int]:
        """Positions (n_nodes, 3) under nodal forces (n_nodes, 3) [N] from `start`, and the factorisations.

        Newton's method with the exact tangent or, where its step does not lower the potential energy, with
        the projected one and a line search.

        Args:
            load: nodal forces.
            start: (n_nodes, 3) positions, by default at rest.
        """
        x, free = (self.mesh.nodes if start is None else start).copy(), ~self.fixed
        for iteration in range(100):
            _, f, K = self.forces(x)
            residual = (f + load)[free].ravel()
            if np.abs(residual).max() < 1e-8 * np.abs(load).sum():
                return x, iteration
            moved = self.line_search(x, solve(K, residual), load, shortest=1.0)
            if moved is None:
                tangent = self.forces(x, PROJECTED)[2]
                moved = self.line_search(x, solve(tangent, residual), load, shortest=1e-4)
            assert moved is not None, "no step lowers the potential energy"
            x = moved
        raise AssertionError(f"no equilibrium: residual {np.abs(residual).max()} N")

    def line_search(self, x: Array, dq: Array, load: Array, shortest: float) -> Array | None:
        """x moved along dq so far that the potential energy falls; None: nowhere."""
        free, scale = ~self.fixed, 1.0

        def merit(at: Array) -> tuple[float, float]:
            energy, f, _ = self.forces(at, NO_TANGENT)
            unbalanced = np.linalg.norm((f + load)[free])
            return energy - float((load * (at - self.mesh.nodes)).sum()), float(unbalanced)

        potential, unbalanced = merit(x)
        while scale >= shortest:
            trial = x.copy()
            trial[free] += scale * dq.reshape(-1, 3)
            value, rest = merit(trial)
            level = value < potential + 1e-9 * abs(potential)  # energies are rounded
            if value < potential or (level and rest < unbalanced):
                return trial
            scale *= 0.5
        return None


def solve(K: sp.csc_array, residual: Array) -> Array:
    """K⁻¹ residual, K symmetric."""
    options = {"SymmetricMode": True}
    factors = splu(K, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.01, options=options)
    dq: Array = factors.solve(residual)
    return dq


def make_body(mesh: TetMesh, kind: Kind, law: Law, fixed: Bools | None = None) -> Body:
    """A body of one law; `fixed` counts the nodes of the elements' own mesh, see `element_mesh`."""
    domains, laws = element_domains(mesh, kind, law)
    own = element_mesh(mesh, kind)
    held = np.zeros(len(own.nodes), dtype=bool) if fixed is None else fixed
    pattern = make_pattern(held, [part.nodes for part in domains])
    return Body(own, held, pattern, make_solid(domains, laws, pattern, len(mesh.tets)))


def body_of_quadratic_mesh(mesh: QuadraticMesh, law: Law, fixed: Bools) -> Body:
    """A body of quadratic tetrahedra that need not be straight."""
    domains = [quadratic_domains(mesh, np.zeros(len(mesh.tets), dtype=np.int64))]
    pattern = make_pattern(fixed, [mesh.tets])
    return Body(mesh.split(), fixed, pattern, make_solid(domains, [law], pattern, len(mesh.tets)))


def element_mesh(mesh: TetMesh, kind: Kind) -> TetMesh:
    """Linear tetrahedra on the nodes of the elements."""
    return quadratic_mesh(mesh).split() if kind == "quadratic" else mesh


def element_domains(mesh: TetMesh, kind: Kind, law: Law) -> tuple[list[Domains], list[Law]]:
    """Domains of a kind of element and the laws they point to."""
    zero: Ints = np.zeros(len(mesh.tets), dtype=np.int64)
    if kind == "linear":
        return [linear_domains(mesh, zero)], [law]
    if kind == "quadratic":
        return [quadratic_domains(quadratic_mesh(mesh), zero)], [law]
    if kind == "edge-node":
        parts = smoothed_domains(mesh, zero, "edge") + smoothed_domains(mesh, zero + 1, "node")
        return parts, list(law.parts())
    return smoothed_domains(mesh, zero, kind), [law]


def face_load(mesh: TetMesh, axis: int, position: float, total: Array) -> Array:
    """A force (3,) [N] spread over the face where coordinate `axis` is `position`: (n_nodes, 3)."""
    triangles = boundary_triangles(mesh.tets)
    on = np.all(np.abs(mesh.nodes[triangles][:, :, axis] - position) < 1e-9, axis=1)
    areas = triangle_areas(mesh.nodes, triangles[on])
    share = np.bincount(triangles[on].ravel(), np.repeat(areas / 3.0, 3), len(mesh.nodes))
    return np.outer(share / share.sum(), total)


RIGID_CUBE = """
name = "cube"
[[bodies]]
name = "block"
rigid = true
free = true
mesh = { file = "cube.vtu" }
material = { young_modulus = 1e8, poisson_ratio = 0.3, density = 2000.0 }
[[surfaces]]
name = "below"
box = { lower = [-1.0, -1.0, -1.0], upper = [1.0, 1.0, 1.0] }
normal = [0.0, 0.0, -1.0]
"""
