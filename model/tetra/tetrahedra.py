"""Tetrahedra on nodes: mass, forces and tangent over the nodes that are not fixed, whatever these follow."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.actuators import Loads, NodalCurvature
from tauten.model.mesh import TetMesh
from tauten.model.numerics import Array, Ints
from tauten.model.points import NodeMotion
from tauten.model.system import Pattern
from tauten.model.tetra.solid import Solid
from tauten.model.tetra.viscoelastic import Viscoelasticity


@dataclass(frozen=True, slots=True, eq=False)
class Tetrahedra:
    """What tetrahedra do to the nodes that are not fixed; m is their number of degrees of freedom.

    Attributes:
        mesh: linear tetrahedra on all nodes at rest; quadratic elements are cut into eight.
        pattern: sparsity of matrices (m, m).
        elements: the finite elements.
        deforming: those of them that can deform; the others move as rigid bodies.
        mass: (m,) lumped mass [kg].
        load: (m,) gravity and outer forces [N].
        curvature: of cables and chambers.
        viscosity: of the materials; None: they are elastic.
    """

    mesh: TetMesh
    pattern: Pattern
    elements: Solid
    deforming: Solid
    mass: Array
    load: Array
    curvature: NodalCurvature
    viscosity: Viscoelasticity | None = None

    @property
    def dof(self) -> Ints:
        """First degree of freedom of a node, −1 where it is fixed: (n_nodes,)."""
        return self.pattern.dof

    @property
    def m(self) -> int:
        """Degrees of freedom of the nodes that are not fixed."""
        return self.pattern.n

    @property
    def relaxed(self) -> Array:
        """The memory of viscous materials without stress."""
        return np.zeros(0 if self.viscosity is None else self.viscosity.memory_size)

    @property
    def at_rest(self) -> Array:
        """Positions (m,) of the nodes that are not fixed, at rest [m]."""
        return self.mesh.nodes[self.dof >= 0].ravel()

    def placed(self, positions: Array) -> Array:
        """All nodes (n_nodes, 3), of positions (m,) of those that are not fixed [m]."""
        x = self.mesh.nodes.copy()
        x[self.dof >= 0] = positions.reshape(-1, 3)
        return x

    def motion(self, x: Array) -> NodeMotion:
        """Nodes at x (n_nodes, 3) with the free ones themselves as unknowns."""
        return NodeMotion(x, self.dof, self.m)

    def forces(
        self, tangent: int, x: Array, loads: Loads | None, D: Array | None = None
    ) -> tuple[Array, Array]:
        """Internal and outer forces (m,) [N], and their tangent as CSC values in `pattern`.

        Args:
            tangent: EXACT, PROJECTED or MATERIAL of `tauten.model.materials.response`.
            x: (n_nodes, 3) node positions [m].
            loads: efforts of cables and chambers, whose curvature enters the tangent.
            D: (nnz,) zeros, overwritten with the stiffness of the material [N/m]; None: it is not wanted.
        """
        force, K = np.zeros_like(x), np.zeros(len(self.pattern.indices))
        self.deforming.assemble(x, tangent, force, K, D)
        if loads is not None:
            self.curvature.add(x, loads, K)
        return force[self.dof >= 0].ravel() + self.load, K

    def potential(self, x: Array) -> float:
        """Elastic energy minus the work of gravity and outer forces at nodes x (n_nodes, 3) [J]."""
        moved = (x - self.mesh.nodes)[self.dof >= 0].ravel()
        return self.deforming.energy(x) - float(self.load @ moved)

    def viscous(
        self, viscosity: Viscoelasticity, x: Array, memory: Array, h: float
    ) -> tuple[Array, Array]:
        """Forces of the memory (m,) [N], and C as CSC values in `pattern`.

        Args:
            viscosity: of the materials.
            x: (n_nodes, 3) node positions where a step starts [m].
            memory: of the state there.
            h: length of the step [s].
        """
        force, C = viscosity.assemble(self.elements, x, memory, h)
        return force[self.dof >= 0].ravel(), C
