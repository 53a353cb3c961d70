"""A robot of bodies with rigid regions, drives and attachments, in the coordinates that they leave."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

import numpy as np
import scipy.sparse as sp

from tauten.model.actuators import Coupling
from tauten.model.body import SparseRobot
from tauten.model.constraints.coordinates import CoordinateMap, ProductPattern
from tauten.model.constraints.frames import Frames
from tauten.model.constraints.joints import FrameJoints
from tauten.model.mesh import TetMesh
from tauten.model.numerics import Array, FactorisationError, Ints
from tauten.model.robot import RobotRows, State
from tauten.model.rows import ContactRows, Rows, stack
from tauten.model.system import Integration, System, make_system
from tauten.model.tetra import TetRobot

R = TypeVar("R", bound=Rows)


@dataclass(frozen=True, slots=True)
class ConstrainedRobot(SparseRobot):
    """A robot of tetrahedra and beams some of whose nodes follow others, a `Robot`; made by `load_robot`.

    Forces, tangent and rows are those of the nodes, multiplied with T = ∂x/∂q (`CoordinateMap`). State.q has
    the positions of free nodes, position and unit quaternion of each rigid region, the unit quaternion of
    each pinned one, and the angle or travel of each drive; State.v has three, six, three and one numbers for
    them. A node of a beam is a rigid region of four nodes: itself and three beside it.

    Attributes, beside those of every sparse robot:
        raw: the same robot without constraints or couplings, over all nodes that are not fixed.
        frames: rigid regions and drives.
        coordinates: the map to the nodes.
        product: pattern of Tᵀ K T and places in it.
        coupling: of all actuators, drives included; None: each is driven alone.
        drive_places: (m,) numbers of the actuated drives among all single actuators.
        driven: (m,) their numbers among the drive regions; hinges are drive regions without an actuator.
        joints: beams and springs between frames; None: there are none.
        spring_values: values of the springs' tangent, see `FrameJoints.entries`.
    """

    raw: TetRobot
    frames: Frames
    coordinates: CoordinateMap
    product: ProductPattern
    coupling: Coupling | None
    drive_places: Ints
    driven: Ints
    joints: FrameJoints | None
    spring_values: Array

    @property
    def mesh(self) -> TetMesh:
        """Linear tetrahedra on all nodes at rest."""
        return self.raw.mesh

    @property
    def size(self) -> float:
        """Diagonal of the bounding box at rest [m]."""
        return self.raw.size

    @property
    def n_nodes(self) -> int:
        """Nodes, fixed ones included."""
        return self.raw.n_nodes

    @property
    def n_elements(self) -> int:
        """Tetrahedra, of smoothed elements those that are averaged, and beams."""
        return self.raw.n_elements

    @property
    def triangles(self) -> Ints:
        """Surface as triples of `points`: (t, 3)."""
        return self.raw.triangles if self.joints is None else self.joints.drawn(self.mesh)

    def turns(self, state: State) -> Array:
        """Rotations of the nodes of beams: (b, 4), unit quaternions."""
        assert self.joints is not None
        return self.frames.quaternions(state.q[3 * len(self.coordinates.free) :])[
            self.joints.turning
        ]

    def rest(self) -> State:
        """The stress-free state at standstill."""
        free = self.raw.rest().q.reshape(-1, 3)[self.coordinates.free]
        return State(np.concatenate([free.ravel(), self.frames.rest()]), np.zeros(self.n))

    def placed(self, state: State) -> tuple[State, Array]:
        """The state of the nodes, and the levers of `Frames.place`: (k, 3) [m]."""
        first, map_ = 3 * len(self.coordinates.free), self.coordinates
        x = np.zeros((map_.n_nodes, 3))
        x[map_.free] = state.q[:first].reshape(-1, 3)
        x[self.frames.nodes], levers = self.frames.place(state.q[first:])
        q = map_.followed(x.ravel())
        return State(q, np.zeros(len(q))), levers

    def nodes(self, state: State) -> Array:
        """Positions of all nodes, fixed ones included: (n_nodes, 3) [m]."""
        return self.raw.nodes(self.placed(state)[0])

    def effector(self, state: State) -> Array:
        """Positions of the effectors: (p, 3) [m]."""
        return self.raw.effector(self.placed(state)[0])

    def effector_values(self, state: State) -> Array:
        """Goal values of the effectors: (n_v,)."""
        return self.raw.effector_values(self.placed(state)[0])

    def points(self, state: State) -> Array:
        """Positions of what `triangles` joins, here all nodes and the outlines of beams: (P, 3) [m]."""
        x = self.nodes(state)
        return x if self.joints is None else self.joints.points(x, self.turns(state))

    def candidates(self, state: State) -> Array:
        """Positions of the contact candidates: (n_c, 3) [m]."""
        return self.raw.candidates(self.placed(state)[0])

    def contact_normals(self, state: State) -> Array:
        """Directions in which contacts push the candidates, NaN out of range: (n_c, 3)."""
        return self.raw.contact_normals(self.placed(state)[0])

    @property
    def segment_owners(self) -> Ints:
        """The actuator of every segment that `actuator_segments` gives: (s,)."""
        others = self.member_numbers(self.raw.actuator_set.segment_members)
        return self.motors(np.concatenate([others, self.drive_places]))

    @property
    def chamber_owners(self) -> Ints:
        """The actuator whose chamber each of `triangles` encloses, −1 where none: (t,)."""
        return self.motors(
            self.member_numbers(self.raw.actuator_set.chamber_members(self.triangles))
        )

    def actuator_segments(self, state: State) -> Array:
        """Segments by which actuators are drawn: (s, 2, 3) [m], see `Robot`."""
        raw_state = self.placed(state)[0]
        drives = self.frames.drive_segments(state.q[3 * len(self.coordinates.free) :])
        return np.concatenate([self.raw.actuator_segments(raw_state), drives[self.driven]])

    def member_numbers(self, others: Ints) -> Ints:
        """Numbers among all single actuators, of numbers (m,) among those that are no drives; −1 remains."""
        count = self.raw.actuator_set.n_members + len(self.drive_places)
        numbers: Ints = np.append(np.setdiff1d(np.arange(count), self.drive_places), -1)[others]
        return numbers

    def motors(self, members: Ints) -> Ints:
        """The actuators (m,) that drive single actuators (m,); −1 remains −1."""
        return members if self.coupling is None else self.coupling.motors_of(members)

    def loaded(self, gravity: Array, effector_force: Array) -> ConstrainedRobot:
        """The robot under another gravity (3,) [m/s²] and forces on its effectors (3 p,) [N]."""
        raw = self.raw.loaded(gravity, effector_force)
        return dataclasses.replace(self, raw=raw, gravity=raw.gravity)

    def displacement(self, dq: Array) -> float:
        """Largest displacement of a node in a change dq (n,) of the configuration [m], or a bound for it."""
        first = 3 * len(self.coordinates.free)
        free, pinned = np.abs(dq[:first]).max(initial=0.0), self.frames.largest_moves(dq[first:])
        return max(float(free), pinned[0]) + pinned[1]

    def forces(
        self, state: State, tension: Array | None = None, exact: bool = False
    ) -> tuple[Array, Array]:
        """Internal forces plus gravity, and the tangent.

        Args:
            state: where to evaluate.
            tension: (n_a,) efforts of the actuators, whose curvature enters the tangent.
            exact: with the change of the rotations of elements and levers: the derivative, symmetrised; not
                always positive definite.

        Returns:
            force (n,) without actuators and contacts, and K = −∂force/∂q as CSC values (nnz,).
        """
        return self.forces_at(state, *self.placed(state), tension, exact)

    def forces_at(
        self, state: State, raw_state: State, levers: Array, tension: Array | None, exact: bool
    ) -> tuple[Array, Array]:
        """`forces` where the nodes are known.

        Args:
            state: where to evaluate.
            raw_state: the nodes there, and
            levers: (k, 3) their levers, from `placed`.
            tension: (n_a,) efforts of the actuators, as in `forces`.
            exact: as in `forces`.
        """
        T = self.coordinates.values(levers)
        efforts = self.efforts(tension)
        force, K = self.raw.forces(raw_state, efforts, exact)
        tangent = self.product.tangent.apply(K, T, len(self.pattern.indices))
        moments = np.zeros(0)
        if self.joints is not None:
            x, Q = self.raw.nodes(raw_state), self.turns(state)
            _, joined, turning, part = self.joints.assemble(x, Q, exact)
            force = force + joined[self.raw.pattern.dof >= 0].ravel()
            moments = turning.ravel()
            values = np.concatenate([part, self.spring_values])
            tangent += self.product.joints.apply(values, T, len(tangent))
        matrix = self.coordinates.matrix(T)
        mapped: Array = matrix.T @ np.concatenate([force, moments])
        preload = self.preload(state)
        if preload is not None:
            mapped = mapped + preload[0]
        if exact and len(self.frames.nodes):
            if efforts is not None and len(efforts) > 0:
                force = force + self.other_rows(raw_state).H.T @ efforts
            self.add_lever_stiffness(levers, force, tangent)
        return mapped, tangent

    def add_lever_stiffness(self, levers: Array, force: Array, K: Array) -> None:
        """Add what turning levers contribute under forces on the nodes to a tangent K (nnz,).

        Args:
            levers: (k, 3) of frame nodes [m].
            force: (3 n_nodes,) on the nodes that are not fixed [N].
            K: CSC values, added to.
        """
        on_frames = (self.coordinates.gather @ force).reshape(-1, 3)
        blocks, drives = self.frames.stiffness(levers, on_frames)
        K[self.product.rigid_places] += blocks
        K[self.product.drive_places] += drives

    def efforts(self, lam: Array | None) -> Array | None:
        """Efforts on the actuators of `raw`, without drives, under lam (n_a,); None for none."""
        if self.coupling is not None:
            lam = self.coupling.efforts(np.zeros(self.n_a) if lam is None else lam)
        return None if lam is None else np.delete(lam, self.drive_places)

    @property
    def motor_coordinates(self) -> Ints:
        """Degrees of freedom that drives hold."""
        return self.n - self.frames.n_drives + self.driven

    def mass_values(self, T: Array) -> Array:
        """Values (nnz,) of the mass matrix Tᵀ M T [kg, kg m, kg m²] for values T of the map."""
        turning = np.zeros(0) if self.joints is None else np.repeat(self.joints.inertia, 3)
        mass = np.concatenate([self.raw.mass, turning])
        return self.product.inertia.apply(mass, T, len(self.pattern.indices))

    def mass_matrix(self, state: State) -> sp.csc_array:
        """The mass matrix (n, n) at a state."""
        values = self.mass_values(self.coordinates.values(self.placed(state)[1]))
        return sp.csc_array(
            (values, self.pattern.indices, self.pattern.indptr), shape=(self.n,) * 2
        )

    def linearise(
        self, state: State, tension: Array | None = None, integration: Integration | None = None
    ) -> System:
        """The system of one step from this state: A, b, v_free (7)-(10).

        Args:
            state: where the step starts.
            tension: (n_a,) last efforts, for the curvature they add to A.
            integration: another scheme than the robot's.

        Raises:
            FactorisationError: A is not positive definite (a state that has blown up).
        """
        scheme = integration or self.integration
        raw_state, levers = self.placed(state)
        T = self.coordinates.values(levers)
        mass, inertia = self.mass_values(T), np.zeros(self.n)
        if not scheme.static and len(self.frames.nodes):
            inertia = self.inertia_force(levers, T, state.v)
        make = partial(make_system, self.pattern, self.factorisation, scheme)
        force, K = self.forces_at(state, raw_state, levers, tension, True)
        try:
            return make(K.copy(), mass, force + inertia, state.v)
        except FactorisationError:
            semidefinite = self.forces_at(state, raw_state, levers, tension, False)[1]
        # past the largest torque a drive holds the robot against its own tangent: stiffness on the diagonal
        # of a drive that is held changes no step towards equilibrium, the semidefinite tangent does
        drives = self.product.drive_places[self.driven]
        K[drives] += semidefinite[drives] + 2.0 * np.abs(K[drives]) + mass[drives] / scheme.h**2
        for tangent in [K, semidefinite] if len(drives) else [semidefinite]:
            try:
                system = make(tangent, mass, force + inertia, state.v)
                return dataclasses.replace(system, exact=False)
            except FactorisationError:
                if tangent is semidefinite:
                    raise
        raise AssertionError("unreachable")

    def inertia_force(self, levers: Array, T: Array, v: Array) -> Array:
        """Centrifugal and gyroscopic forces, −Tᵀ M Ṫ v: (n,).

        Args:
            levers: (k, 3) of frame nodes [m].
            T: values of the map.
            v: (n,) velocity.
        """
        rate = self.frames.centripetal(levers, v[3 * len(self.coordinates.free) :])
        acceleration = self.coordinates.gather.T @ rate.ravel()  # of all nodes
        matrix = self.coordinates.matrix(T)
        on_nodes = np.zeros(
            matrix.shape[0]
        )  # the inertia of a beam's node is the same about all axes
        on_nodes[: len(acceleration)] = self.raw.mass * acceleration
        force: Array = -(matrix.T @ on_nodes)
        return force

    def potential(self, state: State) -> float:
        """Elastic energy minus the work of gravity, outer forces and preloads since rest [J]."""
        preload = self.preload(state)
        raw_state = self.placed(state)[0]
        energy = self.raw.potential(raw_state)
        if self.joints is not None:
            x = self.raw.nodes(raw_state)
            energy += self.joints.assemble(x, self.turns(state), False)[0]
        return energy if preload is None else energy - preload[1]

    def preload(self, state: State) -> tuple[Array, float] | None:
        """Force (n,) of the offsets of couplings, and its work since rest [J]; None without any."""
        if self.coupling is None or not self.coupling.is_preloaded:
            return None
        raw_state, levers = self.placed(state)
        T = self.coordinates.values(levers)
        others = self.through(self.other_rows(raw_state), T)
        members, offsets = self.member_rows(others, state), self.coupling.offsets
        return members.H.T @ offsets, float(offsets @ members.delta)

    def other_rows(self, raw_state: State) -> Rows:
        """Rows of all actuators but drives over the nodes."""
        x, pattern = self.raw.nodes(raw_state), self.raw.pattern
        return self.raw.actuator_set.rows(x, pattern.dof, pattern.n)

    def through(self, rows: R, T: Array) -> R:
        """Rows over nodes as rows over the coordinates, for values T of the map."""
        return dataclasses.replace(rows, H=self.coordinates.through(rows.H, T))

    def inverted(self, state: State) -> int:
        """Number of tetrahedra that are turned inside out."""
        return self.raw.inverted(self.placed(state)[0])

    def rows(self, state: State, contacts: bool = True) -> RobotRows:
        """Rows of effectors, actuators and, with `contacts`, contacts at this state."""
        raw_state, levers = self.placed(state)
        T = self.coordinates.values(levers)
        found = self.raw.rows(raw_state, contacts)
        touching, members = (
            found.contacts,
            self.member_rows(self.through(found.actuators, T), state),
        )
        assert isinstance(touching.rows, Rows)  # of a mesh
        return RobotRows(
            effectors=self.through(found.effectors, T),
            actuators=members if self.coupling is None else self.coupling.rows(members),
            contacts=ContactRows(
                self.through(touching.rows, T), touching.slots, touching.pair, touching.n_slots
            ),
        )

    def member_rows(self, others: Rows, state: State) -> Rows:
        """Rows of all single actuators: drives have the unit rows of their coordinates.

        Args:
            others: those of all actuators but drives.
            state: the state.
        """
        if len(self.driven) == 0:
            return others
        m, n_drives = len(self.driven), self.frames.n_drives
        arrays = np.ones(m), self.motor_coordinates, np.arange(m + 1)
        angles = state.q[len(state.q) - n_drives :][self.driven]
        drives = Rows(sp.csr_array(arrays, shape=(m, self.n)), angles)
        if len(others) == 0:
            return drives
        count = len(others) + m
        order = np.empty(count, dtype=np.int64)
        order[self.drive_places] = len(others) + np.arange(m)
        order[np.setdiff1d(np.arange(count), self.drive_places)] = np.arange(len(others))
        both = stack([others, drives])
        return Rows(both.H[order], both.delta[order])

    def advance(self, state: State, system: System, dv: Array) -> State:
        """The state one step later: v + dv, moved by h (v + dv).

        Args:
            state: before the step.
            system: of the step.
            dv: (n,) change of the velocity.
        """
        v = system.v + dv
        step, first = system.h * v, 3 * len(self.coordinates.free)
        moved = self.frames.moved(state.q[first:], step[first:])
        return State(np.concatenate([state.q[:first] + step[:first], moved]), v)
