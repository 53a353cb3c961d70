"""The robot made of tetrahedra."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from tauten.model.actuators import ActuatorSet
from tauten.model.body import SteppedRobot
from tauten.model.contact import contact_rows
from tauten.model.effectors import NodalEffectors
from tauten.model.materials import EXACT, HELD
from tauten.model.mesh import TetMesh, boundary_triangles
from tauten.model.numerics import Array, Ints
from tauten.model.points import placed_nodes
from tauten.model.robot import RobotRows, State
from tauten.model.rows import ContactRows
from tauten.model.system import System
from tauten.model.tetra.solid import Solid
from tauten.model.tetra.turning import TurningSteps
from tauten.model.tetra.viscoelastic import Viscoelasticity


@dataclass(frozen=True, slots=True)
class TetRobot(SteppedRobot):
    """A soft robot made of tetrahedra, a `Robot`; made by `load_robot`.

    Attributes, beside those of every sparse robot:
        mesh: linear tetrahedra on all nodes at rest; quadratic elements are cut into eight.
        elements: its elements.
        load: (n,) gravity and outer forces on the effectors [N].
        viscosity: of its materials; None: they are elastic.
    """

    actuator_set: ActuatorSet
    effectors: NodalEffectors
    mesh: TetMesh
    elements: Solid
    load: Array
    viscosity: Viscoelasticity | None = None

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
        memory = np.zeros(0 if self.viscosity is None else self.viscosity.memory_size)
        return State(q.copy(), np.zeros_like(q), memory)

    def nodes(self, state: State) -> Array:
        """Positions of all nodes, fixed ones included: (n_nodes, 3) [m]."""
        x = self.mesh.nodes.copy()
        x[self.pattern.dof >= 0] = state.q.reshape(-1, 3)
        return x

    def effector(self, state: State) -> Array:
        """Positions of the effectors: (p, 3) [m]."""
        return self.effectors.positions(self.nodes(state))

    def effector_values(self, state: State) -> Array:
        """Goal values of the effectors: (n_v,)."""
        return self.effectors.values(self.nodes(state))

    def points(self, state: State) -> Array:
        """Positions of what `triangles` joins, here all nodes: (n_nodes, 3) [m]."""
        return self.nodes(state)

    def candidates(self, state: State) -> Array:
        """Positions of the contact candidates: (n_c, 3) [m]."""
        return self.contacts.positions(self.nodes(state))

    @property
    def segment_owners(self) -> Ints:
        """The actuator of every segment that `actuator_segments` gives: (s,)."""
        return self.actuator_set.motors(self.actuator_set.segment_members)

    @property
    def chamber_owners(self) -> Ints:
        """The actuator whose chamber each of `triangles` encloses, −1 where none: (t,)."""
        return self.actuator_set.motors(self.actuator_set.chamber_members(self.triangles))

    def actuator_segments(self, state: State) -> Array:
        """Segments by which cables and forces are drawn: (s, 2, 3) [m], see `Robot`."""
        return self.actuator_set.segments(self.nodes(state))

    def loaded(self, gravity: Array, effector_force: Array) -> TetRobot:
        """The robot under another gravity (3,) [m/s²] and forces on its effectors (3 p,) [N]."""
        body = self.mass * np.tile(gravity, self.n // 3)  # (n,)
        places = self.effectors.kinds.places(self.effectors.placed(self.mesh.nodes))
        pushed = places.H.T @ effector_force
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
        x, dof = self.nodes(state), self.pattern.dof
        force, K = np.zeros_like(x), np.zeros(len(self.pattern.indices))
        self.elements.assemble(x, tangent, force, K)
        self.actuator_set.add_stiffness(x, effort, tangent == EXACT, K)
        total = force[dof >= 0].ravel() + self.load
        preload = self.actuator_set.preload(x, dof, self.n)
        return (total if preload is None else total + preload[0]), K

    def potential(self, state: State) -> float:
        """Elastic energy minus the work of gravity and outer forces since rest [J]."""
        x = self.nodes(state)
        preload = self.actuator_set.preload(x, self.pattern.dof, self.n)
        work = float(self.load @ (state.q - self.rest().q)) + (preload[1] if preload else 0.0)
        return self.elements.energy(x) - work

    def inverted(self, state: State) -> int:
        """Number of tetrahedra that are turned inside out."""
        corners = self.nodes(state)[self.mesh.tets]  # (e, 4, 3)
        volumes = np.linalg.det(corners[:, 1:] - corners[:, :1])  # (e,), of either sign
        return int((volumes < 0.0).sum())

    def viscosity_at(self, state: State, h: float) -> tuple[Array | None, Array | None]:
        """Forces (n,) of viscous materials' memory [N], and matrix C as CSC values (nnz,); None: no such.

        Args:
            state: where a step starts.
            h: its length [s].
        """
        if self.viscosity is None:
            return None, None
        x = self.nodes(state)
        force, C = self.viscosity.assemble(self.elements, x, state.memory, h)
        return force[self.pattern.dof >= 0].ravel(), C

    def energy(self, state: State) -> float:
        """Potential and kinetic energy, and that stored in viscous materials [J]."""
        stored = 0.0 if self.viscosity is None else self.viscosity.energy(state.memory)
        return self.potential(state) + self.kinetic_energy(state.v) + stored

    def velocity(self, start: State, end: State) -> Array:
        """The velocity (n,) that moves one state to another within a step [m/s]."""
        v: Array = (end.q - start.q) / self.h
        return v

    def rows(self, state: State, contacts: bool = True) -> RobotRows:
        """Rows of effectors, actuators and, with `contacts`, contacts at this state."""
        x = self.nodes(state)
        return RobotRows(
            effectors=self.effectors.rows(x),
            actuators=self.actuator_set.rows(x, self.pattern.dof, self.n),
            contacts=self.contact_rows(x) if contacts else self.no_contact_rows(),
        )

    def contact_rows(self, x: Array) -> ContactRows:
        """Gaps and H_c of the candidates in range at node positions x (n_nodes, 3)."""
        placed = placed_nodes(x, self.pattern.dof, self.n)
        return contact_rows(self.contacts.detect(x), placed)

    def turning_steps(self) -> TurningSteps:
        """What makes long steps towards equilibrium turn elements instead of stretching them."""
        return TurningSteps(self.mesh, self.pattern.dof)

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
        before, end = self.nodes(state), self.nodes(after)
        memory = self.viscosity.remembered(self.elements, before, end, state.memory, system.h)
        return dataclasses.replace(after, memory=memory)
