"""The robot made of tetrahedra."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from tauten.model.actuators import Loads, NodalCurvature
from tauten.model.body import SparseRobot
from tauten.model.materials import EXACT, HELD
from tauten.model.mesh import TetMesh, boundary_triangles
from tauten.model.numerics import Array, Ints
from tauten.model.points import MeanPoints, NodeMotion, NodePoints
from tauten.model.robot import State, Turning
from tauten.model.system import System
from tauten.model.tetra.solid import Solid
from tauten.model.tetra.turning import TurningSteps
from tauten.model.tetra.viscoelastic import Viscoelasticity


@dataclass(frozen=True, slots=True, eq=False)
class TetRobot(SparseRobot[NodePoints | MeanPoints]):
    """A soft robot made of tetrahedra, a `Robot`; made by `load_robot`.

    Attributes, beside those of every sparse robot:
        mesh: linear tetrahedra on all nodes at rest; quadratic elements are cut into eight.
        elements: its elements.
        mass: (n,) lumped mass of the free degrees of freedom [kg].
        load: (n,) gravity and outer forces on the effectors [N].
        curvature: of its cables and chambers.
        viscosity: of its materials; None: they are elastic.
    """

    mesh: TetMesh
    elements: Solid
    mass: Array
    load: Array
    curvature: NodalCurvature
    viscosity: Viscoelasticity | None = None

    @property
    def moving_mass(self) -> float:
        """Mass of all nodes that are not fixed [kg]."""
        return float(self.mass[::3].sum())

    @property
    def size(self) -> float:
        """Diagonal of the bounding box at rest [m]."""
        return self.mesh.size

    @property
    def n_nodes(self) -> int:
        """Nodes, fixed ones included."""
        return len(self.mesh.nodes)

    @property
    def n_elements(self) -> int:
        """Tetrahedra, of smoothed elements those that are averaged."""
        return self.elements.n_elements

    @property
    def triangles(self) -> Ints:
        """Surface as triples of `points`: (t, 3)."""
        return boundary_triangles(self.mesh.tets)

    def rest(self) -> State:
        """The stress-free state at standstill."""
        q = self.mesh.nodes[self.pattern.dof >= 0].ravel()
        return State(q.copy(), np.zeros_like(q), self.relaxed)

    @property
    def relaxed(self) -> Array:
        """The memory of viscous materials without stress."""
        return np.zeros(0 if self.viscosity is None else self.viscosity.memory_size)

    def nodes(self, state: State) -> Array:
        """Positions of all nodes, fixed ones included: (n_nodes, 3) [m]."""
        x = self.mesh.nodes.copy()
        x[self.pattern.dof >= 0] = state.q.reshape(-1, 3)
        return x

    def motion(self, state: State) -> NodeMotion:
        """Where the nodes are at a state."""
        return NodeMotion(self.nodes(state), self.pattern.dof, self.n)

    def points(self, state: State) -> Array:
        """Positions of what `triangles` joins, here all nodes: (n_nodes, 3) [m]."""
        return self.nodes(state)

    def loaded(self, gravity: Array, effector_force: Array) -> TetRobot:
        """The robot under another gravity (3,) [m/s²] and forces on its effectors (3 p,) [N]."""
        body = self.mass * np.tile(gravity, self.n // 3)  # (n,)
        pushed = self.effectors.places(self.motion(self.rest())).H.T @ effector_force
        return dataclasses.replace(self, gravity=np.asarray(gravity), load=body + pushed)

    def displacement(self, state: State, dq: Array) -> float:
        """Largest displacement of a node in a change dq (n,) of the configuration [m]."""
        return float(np.abs(dq).max(initial=0.0))

    def forces(
        self, state: State, effort: Array | None = None, exact: bool = False
    ) -> tuple[Array, Array]:
        """Internal forces plus gravity, and the tangent.

        Args:
            state: where to evaluate.
            effort: (n_a,) efforts of the actuators, whose curvature enters the tangent.
            exact: tangent with the change of the rotations: the exact derivative, but not always
                positive definite.

        Returns:
            force (n,) [N] without actuators and contacts, and K = −∂force/∂q as CSC values (nnz,).
        """
        return self.forces_with(EXACT if exact else self.elements.semidefinite, state, effort)

    def stiffness(self, state: State) -> Array:
        """The stiffness of the material, with rotations of corotational elements held: CSC values (nnz,)."""
        return self.forces_with(HELD, state)[1]

    def forces_with(
        self, tangent: int, state: State, effort: Array | None = None
    ) -> tuple[Array, Array]:
        """`forces` with one of the tangents of `tauten.model.materials.response`.

        Args:
            tangent: EXACT, PROJECTED or HELD.
            state: as in `forces`.
            effort: as in `forces`.
        """
        motion, actuators = self.motion(state), self.actuator_set
        loads = actuators.loads(actuators.efforts(effort), tangent == EXACT)
        total, K = self.nodal_forces(tangent, motion.x, loads)
        preload = actuators.preload(motion)
        return (total if preload is None else total + preload[0]), K

    def nodal_forces(self, tangent: int, x: Array, loads: Loads | None) -> tuple[Array, Array]:
        """Internal and outer forces on the nodes that are not fixed, and their tangent.

        Args:
            tangent: as in `forces_with`.
            x: (n_nodes, 3) node positions [m].
            loads: efforts of cables and chambers, whose curvature enters the tangent.
        """
        force, K = np.zeros_like(x), np.zeros(len(self.pattern.indices))
        self.elements.assemble(x, tangent, force, K)
        if loads is not None:
            self.curvature.add(x, loads, K)
        return force[self.pattern.dof >= 0].ravel() + self.load, K

    def potential(self, state: State) -> float:
        """Elastic energy minus the work of gravity and outer forces since rest [J]."""
        motion = self.motion(state)
        preload = self.actuator_set.preload(motion)
        return self.nodal_potential(motion.x) - (preload[1] if preload else 0.0)

    def nodal_potential(self, x: Array) -> float:
        """Elastic energy minus the work of gravity and outer forces at nodes x (n_nodes, 3) [J]."""
        moved = (x - self.mesh.nodes)[self.pattern.dof >= 0].ravel()
        return self.elements.energy(x) - float(self.load @ moved)

    def inverted(self, state: State) -> int:
        """Number of tetrahedra that are turned inside out."""
        return self.mesh.inverted(self.nodes(state))

    def viscosity_at(self, state: State, h: float) -> tuple[Array | None, Array | None]:
        """Forces (n,) of viscous materials' memory [N], and matrix C as CSC values (nnz,); None: no such.

        Args:
            state: where a step starts.
            h: its length [s].
        """
        if self.viscosity is None:
            return None, None
        return self.nodal_viscosity(self.viscosity, self.nodes(state), state.memory, h)

    def nodal_viscosity(
        self, viscosity: Viscoelasticity, x: Array, memory: Array, h: float
    ) -> tuple[Array, Array]:
        """Forces of the memory on the nodes that are not fixed (m,) [N], and C as CSC values (nnz,).

        Args:
            viscosity: of its materials.
            x: (n_nodes, 3) node positions where a step starts [m].
            memory: of the state there.
            h: length of the step [s].
        """
        force, C = viscosity.assemble(self.elements, x, memory, h)
        return force[self.pattern.dof >= 0].ravel(), C

    def remembered(self, before: Array, after: Array, memory: Array, h: float) -> Array:
        """The memory of viscous materials at the end of a step.

        Args:
            before: (n_nodes, 3) node positions where it starts [m].
            after: (n_nodes, 3) those where it ends [m].
            memory: of the state where it starts.
            h: its length [s].
        """
        if self.viscosity is None:
            return memory
        return self.viscosity.remembered(self.elements, before, after, memory, h)

    def stored(self, state: State) -> float:
        """Energy stored in the memory of viscous materials [J]."""
        return 0.0 if self.viscosity is None else self.viscosity.energy(state.memory)

    def masses(self, state: State) -> Array:
        """Lumped masses (n,), the same at any state."""
        return self.mass

    def turning_steps(self) -> Turning:
        """What makes long steps towards equilibrium turn elements instead of stretching them."""
        steps = TurningSteps(self.mesh, self.pattern.dof)
        return lambda state, u: steps.turned(self.nodes(state), u)

    def advance(self, state: State, system: System, dv: Array) -> State:
        """The state one step later: v + dv and q + h (v + dv), at standstill when quasi-static.

        Args:
            state: before the step.
            system: of the step.
            dv: (n,) change of the velocity [m/s].
        """
        v = system.v + dv
        after = State(state.q + system.h * v, v)
        if self.viscosity is None:
            return after
        memory = self.remembered(self.nodes(state), self.nodes(after), state.memory, system.h)
        return dataclasses.replace(after, memory=memory)
