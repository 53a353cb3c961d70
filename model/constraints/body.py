"""The body with rigid regions, drives and attachments, in the coordinates that these leave."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np

from tauten.model.body import RATES, SparseAssembled
from tauten.model.constraints.coordinates import CoordinateMap, NodeMap, ProductPattern
from tauten.model.constraints.drums import Drums
from tauten.model.constraints.frames import Frames
from tauten.model.constraints.joints import FrameJoints
from tauten.model.materials import EXACT, MATERIAL
from tauten.model.mesh import boundary_triangles
from tauten.model.numerics import Array, FactorisationError, Ints, longest, positive_part
from tauten.model.points import NodeMotion
from tauten.model.rows import Rows
from tauten.model.state import State
from tauten.model.system import Integration, Tangent
from tauten.model.tetra import TetBody

LEAST = 1e-9  # of the mass over the square of a time step: less stiffness is rounding


@dataclass(frozen=True, slots=True, eq=False)
class ConstrainedBody(TetBody):
    """A body of tetrahedra and beams some of whose nodes follow others.

    State.q has the positions of free nodes, position and unit quaternion of each rigid region, the unit
    quaternion of each pinned one, and the angle or travel of each drive; State.v has three, six, three and
    one numbers for them. A node of a beam is a rigid region of four nodes: itself and three beside it.

    Forces, tangent and rows are those of the nodes, multiplied with T = ∂x/∂q (`CoordinateMap`).

    Attributes, beside those of every body of tetrahedra:
        frames: rigid regions and drives.
        coordinates: the map to the nodes.
        driven: (m,) numbers of the actuated drives among the drive regions; hinges are drive regions without
            an actuator.
        joints: beams and springs between frames; None: there are none.
        product: pattern of Tᵀ K T and places in it.
        spring_values: values of the springs' tangent, see `FrameJoints.entries`.
        drums: motors that wind several cables; None: there are none.
    """

    frames: Frames
    coordinates: CoordinateMap
    driven: Ints
    joints: FrameJoints | None
    product: ProductPattern
    spring_values: Array
    drums: Drums | None

    @property
    def of_beams(self) -> bool:
        """Whether beams are all that deforms, see `SparseBody`.

        Drums are held by the stretch of their cables, which plans may not leave out.
        """
        has_beams = self.joints is not None and len(self.joints.nodes) > 0
        return has_beams and self.drums is None and not self.tetrahedra.deforming.domains

    @property
    def triangles(self) -> Ints:
        """Surface as triples of `points`: (t, 3)."""
        if self.joints is None:
            return boundary_triangles(self.mesh.tets)
        return self.joints.drawn(self.mesh)

    def turns(self, state: State) -> Array:
        """Rotations of the nodes of beams: (b, 4), unit quaternions."""
        assert self.joints is not None
        every = self.frames.quaternions(state.q[3 * len(self.coordinates.free) :])
        return every[self.joints.turning]

    def rest(self) -> State:
        """The stress-free state at standstill."""
        free = self.tetrahedra.at_rest.reshape(-1, 3)[self.coordinates.free]
        q = np.concatenate([free.ravel(), self.frames.rest()])
        return State(q, np.zeros(self.n), self.tetrahedra.relaxed)

    def placed(self, state: State) -> tuple[Array, NodeMap]:
        """Positions (3 m,) of the nodes that are not fixed [m], and the map there."""
        first, map_ = 3 * len(self.coordinates.free), self.coordinates
        x = np.zeros((map_.n_nodes, 3))
        x[map_.free] = state.q[:first].reshape(-1, 3)
        x[self.frames.nodes], levers = self.frames.place(state.q[first:])
        return map_.followed(x.ravel()), NodeMap(map_, levers, map_.values(levers))

    def motion(self, state: State) -> NodeMotion:
        """Where the nodes are at a state, and how they move with the coordinates."""
        return self.placed_motion(state)[0]

    def placed_motion(self, state: State) -> tuple[NodeMotion, NodeMap]:
        """`motion`, and its map to the nodes."""
        positions, through = self.placed(state)
        held, angles = self.tetrahedra, state.q[len(state.q) - self.frames.n_drives :]
        return NodeMotion(held.placed(positions), held.dof, held.m, through, angles), through

    def points(self, state: State) -> Array:
        """Positions of what `triangles` joins, here all nodes and the outlines of beams: (P, 3) [m]."""
        x = self.nodes(state)
        return x if self.joints is None else self.joints.points(x, self.turns(state))

    def displacement(self, state: State, dq: Array) -> float:
        """Largest displacement of a node in a change dq (n,) of the configuration, about [m]."""
        first = 3 * len(self.coordinates.free)
        free, pinned = longest(dq[:first]), self.frames.largest_moves(dq[first:])
        return max(free, pinned[0]) + pinned[1]

    def forces(
        self, state: State, effort: Array | None = None, exact: bool = False
    ) -> tuple[Array, Array]:
        """Internal forces plus gravity, and the tangent as CSC values (nnz,), see `Robot`.

        The derivative, with the change of the rotations of elements and levers, is symmetrised.
        """
        kind = EXACT if exact else self.tetrahedra.elements.semidefinite
        return self.forces_at(state, *self.placed_motion(state), effort, kind)

    def stiffness(self, state: State) -> Array:
        """The stiffness of the material, carried along with the elements, as CSC values (nnz,)."""
        return self.forces_at(state, *self.placed_motion(state), None, MATERIAL, pulled=False)[1]

    def forces_and_stiffness(
        self, state: State, effort: Array | None
    ) -> tuple[Array, Array, Array]:
        """`forces` with the exact tangent, and `stiffness`; one pass without beams, springs and drums."""
        if self.joints is not None or self.drums is not None:
            return (*self.forces(state, effort, exact=True), self.stiffness(state))
        motion, through = self.placed_motion(state)
        D = np.zeros(len(self.tetrahedra.pattern.indices))
        force, K = self.forces_at(state, motion, through, effort, EXACT, D)
        return force, K, self.mapped(D, through.T, not self.tetrahedra.deforming.domains)

    def forces_at(
        self, state: State, motion: NodeMotion, through: NodeMap, effort: Array | None, kind: int,
        D: Array | None = None, pulled: bool = True,
    ) -> tuple[Array, Array]:  # fmt: skip
        """`forces` where the nodes are known.

        Args:
            state: where to evaluate.
            motion: of the nodes there, and
            through: its map to them, from `placed_motion`.
            effort: (n_a,) efforts of the actuators, as in `forces`.
            kind: of tangent, see `NodalBody.forces_with`.
            D: zeros, overwritten with the stiffness of the elements over the nodes; None: it is not wanted.
            pulled: whether drums and the curvature of cables and chambers enter the tangent.
        """
        exact, actuators, T = kind == EXACT, self.actuator_set, through.T
        efforts, winding, parts = actuators.efforts(effort), np.zeros(0), list[Array]()
        by_drums = np.zeros(self.tetrahedra.m)
        if self.drums is not None:
            rows, tensions = self.wound(motion)
            efforts = np.zeros(len(actuators.others)) if efforts is None else efforts
            efforts[self.drums.cables] = tensions
            by_drums = rows.H[self.drums.cables].T @ tensions
            winding = -self.drums.efforts(tensions)
            parts = [float(pulled) * self.drums.tangent(rows.H, tensions)]
        loads = actuators.loads(efforts, exact) if pulled else None
        force, K = self.tetrahedra.forces(kind, motion.x, loads, D)
        tangent = self.mapped(K, T, self.is_rigid)
        moments = np.zeros(0)
        if self.joints is not None:
            Q = self.turns(state)
            _, joined, turning, part = self.joints.assemble(motion.x, Q, exact)
            force = force + joined[motion.dof >= 0].ravel()
            moments = turning.ravel()
            parts = [part, self.spring_values, *parts]
        if parts:
            tangent += self.product.joints.apply(np.concatenate(parts), T, len(tangent))
        mapped = through.forces(np.concatenate([force + by_drums, moments, winding]))
        preload = actuators.preload(motion)
        if preload is not None:
            mapped = mapped + preload[0]
        if pulled and len(self.frames.nodes):
            if efforts is not None and len(efforts) > 0:
                others = actuators.other_rows(self.tetrahedra.motion(motion.x))
                force = force + others.weighed(efforts)
            self.add_lever_stiffness(through.levers, force, tangent, exact)
        return mapped, tangent

    @property
    def is_rigid(self) -> bool:
        """Whether nothing deforms, so that the nodes have no tangent: neither elements nor cables."""
        single, driven = self.actuator_set.n_members, len(self.actuator_set.drives)
        return single == driven and not self.tetrahedra.deforming.domains

    def mapped(self, K: Array, T: Array, is_zero: bool) -> Array:
        """Values (nnz,) of Tᵀ K T.

        Args:
            K: values of a matrix of the nodes.
            T: values of the map.
            is_zero: whether all values are zero, which need no products.
        """
        size = len(self.pattern.indices)
        return np.zeros(size) if is_zero else self.product.tangent.apply(K, T, size)

    def add_lever_stiffness(self, levers: Array, force: Array, K: Array, exact: bool) -> None:
        """Add what turning levers contribute under forces on the nodes to a tangent K (nnz,).

        Args:
            levers: (k, 3) of frame nodes [m].
            force: (3 n_nodes,) on the nodes that are not fixed [N].
            K: CSC values, added to.
            exact: whether all of it is added, or only what is positive semidefinite.
        """
        on_frames = (self.coordinates.gather @ force).reshape(-1, 3)
        blocks, drives = self.frames.stiffness(levers, on_frames)
        if not exact:
            blocks, drives = positive_part(blocks), np.maximum(drives, 0.0)
        K[self.product.rigid_places] += blocks
        K[self.product.drive_places] += drives

    def masses(self, state: State) -> Array:
        """Values (nnz,) of the mass matrix Tᵀ M T at a state [kg, kg m, kg m²].

        Raises:
            FactorisationError: the state has diverged, and has no rotations any more.
        """
        if not np.logical_and.reduce(np.isfinite(state.q)):
            raise FactorisationError("not finite")
        T = self.placed(state)[1].T
        turning = np.zeros(0) if self.joints is None else np.repeat(self.joints.inertia, 3)
        winding = np.zeros(0 if self.drums is None else len(self.drums.motors))
        mass = np.concatenate([self.tetrahedra.mass, turning, winding])
        values = self.product.inertia.apply(mass, T, len(self.pattern.indices))
        if self.frames.is_lumped:
            blocks, drives = self.frames.excess_inertia(state.q[3 * len(self.coordinates.free) :])
            values[self.product.rigid_places] -= blocks
            values[self.product.drive_places] -= drives
        return values

    def inertia_at(self, state: State) -> Array | None:
        """Centrifugal and gyroscopic forces (n,) at a state, −Tᵀ M Ṫ v [N]; None where no frame turns."""
        if len(self.frames.nodes) == 0:
            return None
        through, first = self.placed(state)[1], 3 * len(self.coordinates.free)
        rate = self.frames.centripetal(through.levers, state.v[first:])
        acceleration = self.coordinates.spread @ rate.ravel()  # of all nodes
        # the inertia of a beam's node is the same about all axes
        found = -through.forces(self.tetrahedra.mass * acceleration)
        if self.frames.is_lumped:
            found[first:] += self.frames.excess_moments(state.q[first:], state.v[first:])
        return found

    def tangents(self, at: SparseAssembled, scheme: Integration) -> Iterator[Tangent]:
        """What a step tries, see `SparseBody.tangents`.

        Past the largest torque a drive holds the body against its own tangent: stiffness on the diagonal of a
        drive that is held changes no step towards equilibrium, the semidefinite tangent does. Nor has a rigid
        body that a drive moves a stiffness of its own, where the step is static; of a soft body that goes
        along whole the tangent is singular, and its factors may be those of rounding. Links that only cables
        hold on their hinges have a negative one at given tensions, which no tangent of elements makes
        positive. Then the mass over the square of a time is added, of a long time first, as in the
        pseudo-transient continuation of `tauten.model.simulation.relaxation`; of a second first where bodies
        on pins turn freely, as about the line from the pin to their centre, and all else is exact. See
        `SparseBody`.
        """
        semidefinite = cache(lambda: self.semidefinite(at, scheme))
        tried = self.tried(at, scheme, semidefinite)
        if len(self.driven):
            tried = self._with_drives_stiffer(tried, at, scheme, semidefinite)
        if scheme.static and self.frames.n_pinned > 0:
            tried = self._with_pins_held(tried, at)
        yield from tried
        if scheme.static:
            M = self.masses(at.state)
            for rate in RATES:
                yield Tangent(semidefinite() + rate**2 * M, False, 1.0)

    def _with_pins_held(self, tried: Iterator[Tangent], at: SparseAssembled) -> Iterator[Tangent]:
        """What a static step tries, and after the exact tangent, which may be singular, it with the mass."""
        mass, first = RATES[0] ** 2 * self.masses(at.state), self.frames.n_rigid
        places = self.product.rigid_places[first:, np.arange(3), np.arange(3)]
        held = np.abs(at.K[places]).sum(axis=1) + mass[places].sum(axis=1)  # (n_pinned,) N m
        turns = 3 * len(self.coordinates.free) + self.frames.rotations[first:, None] + np.arange(3)
        for one in tried:
            if not one.exact:
                yield one
                continue
            unknowns, stiffness = one.unheld or (np.zeros(0, np.int64), np.zeros(0))
            both = (
                np.concatenate([unknowns, turns.ravel()]),
                np.concatenate([stiffness, held.repeat(3)]),
            )
            yield one._replace(unheld=both)
            yield Tangent(one.values + mass, False, 0.0)

    def _with_drives_stiffer(
        self,
        tried: Iterator[Tangent],
        at: SparseAssembled,
        scheme: Integration,
        semidefinite: Callable[[], Array],
    ) -> Iterator[Tangent]:
        """What a step tries, and after the exact tangent the same with more on the diagonal of drives."""
        drives = self.product.drive_places[self.driven]
        mass = (self.masses(at.state) if scheme.static else at.mass)[drives] / scheme.h**2
        loose = scheme.static and bool((at.K[drives] < LEAST * mass).any())
        unknowns = 3 * len(self.coordinates.free) + self.frames.drives[self.driven]
        for one in tried:
            if not one.exact:
                yield one
            elif not loose:
                yield one._replace(unheld=(unknowns, at.K[drives])) if scheme.static else one
            if one.exact:
                D, K = semidefinite() if at.D is None else at.D, at.K.copy()
                more = D[drives] + 2.0 * np.abs(K[drives]) + mass
                K[drives] += more
                yield Tangent(K, False, 0.0, (unknowns, more))

    def viscosity_at(self, state: State, h: float) -> tuple[Array | None, Array | None]:
        """Forces (n,) of viscous materials' memory [N], and matrix C as CSC values (nnz,); None: no such.

        See `SparseBody`.
        """
        held = self.tetrahedra
        if held.viscosity is None:
            return None, None
        motion, through = self.placed_motion(state)
        force, C = held.viscous(held.viscosity, motion.x, state.memory, h)
        mapped = self.product.tangent.apply(C, through.T, len(self.pattern.indices))
        return through.forces(force), mapped

    def potential(self, state: State) -> float:
        """Elastic energy minus the work of gravity, outer forces and preloads since rest [J]."""
        motion = self.motion(state)
        preload, energy = self.actuator_set.preload(motion), self.tetrahedra.potential(motion.x)
        if self.joints is not None:
            energy += self.joints.assemble(motion.x, self.turns(state), False)[0]
        if self.drums is not None:
            theta = motion.travel[self.drums.regions]
            energy += self.drums.energy(self.wound(motion)[0].delta, theta)
        return energy if preload is None else energy - preload[1]

    def velocity(self, start: State, end: State) -> Array:
        """The velocity (n,) that moves one state to another within a step [m/s], [rad/s].

        Rotations of up to π in a step.
        """
        first = 3 * len(self.coordinates.free)
        straight = end.q[:first] - start.q[:first]
        v: Array = np.concatenate([straight, self.frames.between(start.q[first:], end.q[first:])])
        return v / self.h

    def at_end(self, start: State, end: State, force: Array) -> Array:
        """Forces (n,) at the end of a step that do the work of given ones at its start [N, N m].

        See `Body`.
        """
        first = 3 * len(self.coordinates.free)
        step = self.frames.between(start.q[first:], end.q[first:])
        return np.concatenate([force[:first], self.frames.at_end(step, force[first:])])

    def wound(self, motion: NodeMotion) -> tuple[Rows, Array]:
        """Rows of all cables over the nodes, and tensions [N] of those on drums."""
        assert self.drums is not None
        actuators = self.actuator_set
        rows = actuators.paths.rows(self.tetrahedra.motion(motion.x).placed(actuators.stations))
        return rows, self.drums.tensions(rows.delta, motion.travel[self.drums.regions])

    def advance(self, state: State, v: Array, h: float, straight: bool = False) -> State:
        """The state one step later, see `Robot`."""
        step, first = h * v, 3 * len(self.coordinates.free)
        moved = self.frames.moved(state.q[first:], step[first:])
        after = State(np.concatenate([state.q[:first] + step[:first], moved]), v)
        return self.remembering(state, after, h)
