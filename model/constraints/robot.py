"""A robot of bodies with rigid regions, drives and attachments, in the coordinates that they leave."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

import numpy as np
import scipy.sparse as sp

from tauten.model.actuators import motor_rows
from tauten.model.body import SparseAssembled
from tauten.model.constraints.coordinates import ProductPattern
from tauten.model.constraints.drums import Drums, with_unit_rows
from tauten.model.constraints.placed_robot import PlacedRobot
from tauten.model.materials import EXACT, HELD
from tauten.model.numerics import Array, FactorisationError, Ints
from tauten.model.robot import Assembled, RobotRows, State
from tauten.model.rows import ContactRows, Rows
from tauten.model.system import Integration, System, make_system

R = TypeVar("R", bound=Rows)


@dataclass(frozen=True, slots=True)
class ConstrainedRobot(PlacedRobot):
    """A robot of tetrahedra and beams some of whose nodes follow others, a `Robot`; made by `load_robot`.

    Forces, tangent and rows are those of the nodes, multiplied with T = ∂x/∂q (`CoordinateMap`).

    Attributes, beside those of `PlacedRobot`:
        product: pattern of Tᵀ K T and places in it.
        spring_values: values of the springs' tangent, see `FrameJoints.entries`.
        drums: motors that wind several cables; None: there are none.
    """

    product: ProductPattern
    spring_values: Array
    drums: Drums | None

    def loaded(self, gravity: Array, effector_force: Array) -> ConstrainedRobot:
        """The robot under another gravity (3,) [m/s²] and forces on its effectors (3 p,) [N]."""
        raw = self.raw.loaded(gravity, effector_force)
        return dataclasses.replace(self, raw=raw, gravity=raw.gravity)

    def displacement(self, state: State, dq: Array) -> float:
        """Largest displacement of a node in a change dq (n,) of the configuration [m], or a bound for it."""
        first = 3 * len(self.coordinates.free)
        free, pinned = np.abs(dq[:first]).max(initial=0.0), self.frames.largest_moves(dq[first:])
        return max(float(free), pinned[0]) + pinned[1]

    def forces(
        self, state: State, effort: Array | None = None, exact: bool = False
    ) -> tuple[Array, Array]:
        """Internal forces plus gravity, and the tangent.

        Args:
            state: where to evaluate.
            effort: (n_a,) efforts of the actuators, whose curvature enters the tangent.
            exact: with the change of the rotations of elements and levers: the derivative, symmetrised; not
                always positive definite.

        Returns:
            force (n,) without actuators and contacts, and K = −∂force/∂q as CSC values (nnz,).
        """
        semidefinite = self.raw.elements.semidefinite
        return self.forces_at(state, *self.placed(state), effort, EXACT if exact else semidefinite)

    def stiffness(self, state: State) -> Array:
        """The stiffness of the material, with rotations of elements held, as CSC values (nnz,)."""
        return self.forces_at(state, *self.placed(state), None, HELD)[1]

    def forces_at(
        self, state: State, raw_state: State, levers: Array, effort: Array | None, kind: int
    ) -> tuple[Array, Array]:
        """`forces` where the nodes are known.

        Args:
            state: where to evaluate.
            raw_state: the nodes there, and
            levers: (k, 3) their levers, from `placed`.
            effort: (n_a,) efforts of the actuators, as in `forces`.
            kind: of tangent, see `TetRobot.forces_with`.
        """
        exact = kind == EXACT
        T = self.coordinates.values(levers)
        efforts, winding, parts = self.efforts(effort), np.zeros(0), list[Array]()
        pulled = np.zeros(self.raw.n)
        if self.drums is not None:
            rows, tensions = self.wound(state, raw_state)
            efforts = np.zeros(self.raw.n_a) if efforts is None else efforts
            efforts[self.drums.cables] = tensions
            pulled, winding = rows.H[self.drums.cables].T @ tensions, -self.drums.efforts(tensions)
            parts = [self.drums.tangent(rows.H, tensions)]
        force, K = self.raw.forces_with(kind, raw_state, efforts)
        tangent = self.product.tangent.apply(K, T, len(self.pattern.indices))
        moments = np.zeros(0)
        if self.joints is not None:
            x, Q = self.raw.nodes(raw_state), self.turns(state)
            _, joined, turning, part = self.joints.assemble(x, Q, exact)
            force = force + joined[self.raw.pattern.dof >= 0].ravel()
            moments = turning.ravel()
            parts = [part, self.spring_values, *parts]
        if parts:
            tangent += self.product.joints.apply(np.concatenate(parts), T, len(tangent))
        matrix = self.coordinates.matrix(T)
        mapped: Array = matrix.T @ np.concatenate([force + pulled, moments, winding])
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
        """Degrees of freedom that drives and drums hold."""
        drums = np.zeros(0, np.int64) if self.drums is None else self.drums.regions
        return self.n - self.frames.n_drives + np.concatenate([self.driven, drums])

    def mass_values(self, T: Array) -> Array:
        """Values (nnz,) of the mass matrix Tᵀ M T [kg, kg m, kg m²] for values T of the map."""
        turning = np.zeros(0) if self.joints is None else np.repeat(self.joints.inertia, 3)
        winding = np.zeros(0 if self.drums is None else len(self.drums.motors))
        mass = np.concatenate([self.raw.mass, turning, winding])
        return self.product.inertia.apply(mass, T, len(self.pattern.indices))

    def mass_matrix(self, state: State) -> sp.csc_array:
        """The mass matrix (n, n) at a state."""
        values = self.mass_values(self.coordinates.values(self.placed(state)[1]))
        return sp.csc_array(
            (values, self.pattern.indices, self.pattern.indptr), shape=(self.n,) * 2
        )

    def system(self, assembled: Assembled, integration: Integration) -> System:
        """The system of one step, `linearise` where forces and tangents are known.

        Args:
            assembled: by this robot or a fork.
            integration: scheme and length of the step.

        Raises:
            FactorisationError: A is not positive definite (a state that has blown up).
        """
        assert isinstance(assembled, SparseAssembled)
        state, scheme, K = assembled.state, integration, assembled.K
        levers = self.placed(state)[1]
        T = self.coordinates.values(levers)
        mass, force = self.mass_values(T), assembled.force
        if not scheme.static and len(self.frames.nodes):
            force = force + self.inertia_force(levers, T, state.v)
        damping = None if scheme.static else self.damping_with(assembled.D, state, scheme)[1]
        make = partial(make_system, self.pattern, self.factorisation, scheme, damping=damping)
        try:
            return make(K, mass, force, state.v)
        except FactorisationError:
            semidefinite, K = self.forces(state, assembled.effort)[1], K.copy()
        # past the largest torque a drive holds the robot against its own tangent: stiffness on the diagonal
        # of a drive that is held changes no step towards equilibrium, the semidefinite tangent does
        drives = self.product.drive_places[self.driven]
        K[drives] += semidefinite[drives] + 2.0 * np.abs(K[drives]) + mass[drives] / scheme.h**2
        for tangent in [K, semidefinite] if len(drives) else [semidefinite]:
            try:
                system = make(tangent, mass, force, state.v)
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
        if self.drums is not None:
            theta = self.drive_angles(state)[self.drums.regions]
            energy += self.drums.energy(self.wound(state, raw_state)[0].delta, theta)
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
        motors = motor_rows(self.coupling, members)
        if self.drums is not None:
            theta = self.drive_angles(state)[self.drums.regions]
            motors = self.drums.motor_rows(
                motors, self.motor_coordinates[len(self.driven) :], theta
            )
        return RobotRows(
            effectors=self.through(found.effectors, T),
            actuators=motors,
            contacts=ContactRows(self.through(touching.rows, T), touching.found),
        )

    def member_rows(self, others: Rows, state: State) -> Rows:
        """Rows of all single actuators: drives have the unit rows of their coordinates.

        Args:
            others: those of all actuators but drives.
            state: the state.
        """
        angles = self.drive_angles(state)[self.driven]
        columns = self.n - self.frames.n_drives + self.driven
        return with_unit_rows(others, self.drive_places, columns, angles)

    def drive_angles(self, state: State) -> Array:
        """Angle or travel of every drive region: (n_drives,)."""
        return state.q[len(state.q) - self.frames.n_drives :]

    def wound(self, state: State, raw_state: State) -> tuple[Rows, Array]:
        """Rows of all cables over the nodes, and tensions [N] of those on drums."""
        assert self.drums is not None
        cables, pattern = self.raw.actuator_set.cables, self.raw.pattern
        x = self.raw.nodes(raw_state)
        rows = cables.paths.rows(cables.placed(x, pattern.dof, pattern.n))
        theta = self.drive_angles(state)[self.drums.regions]
        return rows, self.drums.tensions(rows.delta, theta)

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
