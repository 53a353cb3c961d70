"""The robot made of tetrahedra.

`linearise` gives the system of one step, `rows` what effectors, cables and contacts add to it,
`advance` moves the state, `rest` is where it starts. A robot is immutable but for the workspace
of its factorisation: whoever steps it takes its own with `fork`.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from tauten.model.arrays import Array, Ints
from tauten.model.attachment import Points
from tauten.model.cable import CableSet, add_cable_stiffness
from tauten.model.config import RobotConfig
from tauten.model.contact import ContactSet, contact_rows
from tauten.model.effector import effector_rows
from tauten.model.factorisation import Factorisation, FactorisationError, make_factorisation
from tauten.model.limits import Limits
from tauten.model.material import Material
from tauten.model.mesh import TetMesh
from tauten.model.robot import RobotRows, State
from tauten.model.rows import ContactRows, PairSlots, Rows
from tauten.model.surface import boundary_triangles
from tauten.model.system import Integration, Pattern, System, make_system
from tauten.model.tetrahedra import assemble


@dataclass(frozen=True, slots=True)
class Elements:
    """Rest data of the tetrahedra and where they enter the pattern (see `tetrahedra.assemble`)."""

    gradients: Array
    volumes: Array
    slot: Ints
    column_length: Ints


@dataclass(frozen=True, slots=True)
class TetRobot:
    """A cable-driven soft robot made of tetrahedra, a `Robot`; made by `load_robot`.

    Attributes:
        config: the robot file.
        digest: SHA-256 over all that decides its contact forces (mesh, material, cables, contacts).
        mesh: the body at rest.
        material: its material.
        integration: time step and scheme.
        pattern: sparsity of its matrices.
        elements: rest data of the tetrahedra.
        mass: (n,) lumped mass of the free degrees of freedom [kg].
        load: (n,) gravity and outer forces on the effectors [N].
        cables: its cables.
        cable_slot: places of the cables' curvature in the pattern.
        limits: what the winches can do.
        effectors: material points that reach targets.
        H_e: (3 p, n) their constant rows.
        contacts: candidates and the surfaces they may touch.
        factorisation: workspace of the linear solver.
    """

    config: RobotConfig
    digest: str
    mesh: TetMesh
    material: Material
    integration: Integration
    pattern: Pattern
    elements: Elements
    mass: Array
    load: Array
    cables: CableSet
    cable_slot: tuple[Ints, Ints]
    limits: Limits
    effectors: Points
    H_e: sp.csr_array
    contacts: ContactSet
    factorisation: Factorisation

    @property
    def name(self) -> str:
        """Name in keys and messages."""
        return self.config.name

    @property
    def frame(self) -> str:
        """Frame id of its positions on the wire."""
        return self.config.frame

    @property
    def h(self) -> float:
        """Time step [s]."""
        return self.integration.h

    @property
    def n(self) -> int:
        """Free degrees of freedom."""
        return self.pattern.n

    @property
    def n_a(self) -> int:
        """Cables."""
        return self.cables.n_a

    @property
    def n_e(self) -> int:
        """Effector rows, three a point."""
        return 3 * len(self.effectors)

    @property
    def n_c(self) -> int:
        """Contact candidates, slots of λ_c."""
        return self.contacts.n_slots

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
        """Tetrahedra."""
        return len(self.mesh.tets)

    @property
    def linear_solver(self) -> str:
        """Name of the factorisation in use."""
        return self.factorisation.name

    @property
    def triangles(self) -> Ints:
        """Surface as triples of `points`: (t, 3)."""
        return boundary_triangles(self.mesh.tets)

    @property
    def pairs(self) -> tuple[PairSlots, ...]:
        """Contact pairs in the order of their slots."""
        return self.contacts.pair_slots

    @property
    def cable_names(self) -> tuple[str, ...]:
        """Names of the cables, in the order of λ_a."""
        return tuple(cable.name for cable in self.config.cables)

    @property
    def effector_names(self) -> tuple[str, ...]:
        """Names of the effectors, in row order."""
        return tuple(effector.name for effector in self.config.effectors)

    def fork(self) -> TetRobot:
        """The same robot with a factorisation workspace of its own."""
        backend = self.config.integration.factorisation
        workspace = make_factorisation(self.pattern.indptr, self.pattern.indices, backend)
        return dataclasses.replace(self, factorisation=workspace)

    def rest(self) -> State:
        """The stress-free state at standstill."""
        q = self.mesh.nodes[self.pattern.dof >= 0].ravel()
        return State(q.copy(), np.zeros_like(q))

    def nodes(self, state: State) -> Array:
        """Positions of all nodes, fixed ones included: (n_nodes, 3) [m]."""
        x = self.mesh.nodes.copy()
        x[self.pattern.dof >= 0] = state.q.reshape(-1, 3)
        return x

    def effector(self, state: State) -> Array:
        """Positions of the effectors: (p, 3) [m]."""
        return self.effectors.positions(self.nodes(state))

    def points(self, state: State) -> Array:
        """Positions of what `triangles` joins, here all nodes: (n_nodes, 3) [m]."""
        return self.nodes(state)

    def candidates(self, state: State) -> Array:
        """Positions of the contact candidates: (n_c, 3) [m]."""
        return self.contacts.positions(self.nodes(state))

    def loaded(self, gravity: Array, effector_force: Array) -> TetRobot:
        """The robot under another gravity (3,) [m/s²] and forces on its effectors (n_e,) [N]."""
        body = self.mass * np.tile(gravity, self.n // 3)  # (n,)
        return dataclasses.replace(self, load=body + self.H_e.T @ effector_force)

    def displacement(self, dq: Array) -> float:
        """Largest displacement of a node in a change dq (n,) of the configuration [m]."""
        return float(np.abs(dq).max(initial=0.0))

    def forces(
        self, state: State, tension: Array | None = None, exact: bool = False
    ) -> tuple[Array, Array]:
        """Internal forces plus gravity, and the tangent.

        Args:
            state: where to evaluate.
            tension: (n_a,) tensions whose curvature enters the tangent [N].
            exact: tangent with the turning of the rotations: the exact derivative, but not always
                positive definite.

        Returns:
            force (n,) [N] without cables and contacts, and K = −∂force/∂q as CSC values (nnz,).
        """
        x, dof = self.nodes(state), self.pattern.dof
        force, K = np.zeros_like(x), np.zeros(len(self.pattern.indices))
        part = self.elements
        assemble(
            x, self.mesh.tets, part.gradients, part.volumes, self.material.lame, exact,
            part.slot, part.column_length, force, K,
        )  # fmt: skip
        if tension is not None:
            c = self.cables
            add_cable_stiffness(
                x, c.owner, c.nodes, c.weights, c.offset, tension, *self.cable_slot, K
            )
        return force[dof >= 0].ravel() + self.load, K

    def linearise(
        self, state: State, tension: Array | None = None, integration: Integration | None = None
    ) -> System:
        """The system of one step from this state: A, b, v_free (7)-(10).

        Args:
            state: where the step starts.
            tension: (n_a,) last tensions, for the curvature they add to A [N].
            integration: another scheme than the robot's own.

        Raises:
            FactorisationError: A is not positive definite (a state that has blown up).
        """
        scheme = integration or self.integration
        for exact in (True, False):
            force, K = self.forces(state, tension, exact)
            try:
                return make_system(
                    self.pattern, self.factorisation, scheme, K, self.mass, force, state.v
                )
            except FactorisationError:
                # the exact tangent may be indefinite (buckling); with rotations held it is not
                if not exact:
                    raise
        raise AssertionError("unreachable")

    def rows(self, state: State, contacts: bool = True) -> RobotRows:
        """Rows of effectors, cables and, unless told otherwise, contacts at this state."""
        x = self.nodes(state)
        return RobotRows(
            effectors=effector_rows(self.effectors, self.H_e, x),
            actuators=self.cables.rows(x, self.pattern.dof, self.n),
            contacts=self.contact_rows(x) if contacts else self.no_contact_rows(),
        )

    def contact_rows(self, x: Array) -> ContactRows:
        """Gaps and H_c of the candidates in range at node positions x (n_nodes, 3)."""
        return contact_rows(self.contacts.detect(x), self.pattern.dof, self.n, self.n_c)

    def no_contact_rows(self) -> ContactRows:
        """Contact rows with no candidate in range."""
        none = np.zeros(0, dtype=np.int64)
        return ContactRows(Rows(sp.csr_array((0, self.n)), np.zeros(0)), none, none, self.n_c)

    def advance(self, state: State, system: System, dv: Array) -> State:
        """The state one step later: v + dv and q + h (v + dv), at standstill when quasi-static."""
        v = system.v + dv
        return State(state.q + system.h * v, v)
