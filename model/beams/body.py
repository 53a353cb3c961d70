"""The body made of beams, with surfaces, cables and effectors attached to them."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from tauten.model.beams.arcs import forces_at_end, moved_along_arcs, step_along_arcs
from tauten.model.beams.beams import Beams
from tauten.model.beams.elements import assemble_beams
from tauten.model.beams.surfaces import BeamSurfaces
from tauten.model.beams.tree import BeamTree
from tauten.model.body import SparseBody
from tauten.model.effectors import Effectors
from tauten.model.numerics import (
    Array,
    Ints,
    diameter,
    longest,
    moments_at_end,
    rotations_between,
    turned,
)
from tauten.model.points import (
    AttachedPoints,
    OuterForces,
    PoseMotion,
    add_beam_cable_stiffness,
    add_lever_stiffness,
)
from tauten.model.state import State, StepStart


@dataclass(frozen=True, slots=True, eq=False)
class BeamBody(SparseBody[AttachedPoints]):
    """A body made of beams, driven by cables and forces.

    A node has six degrees of freedom: its position, and rotations about the fixed axes. For each free node q
    holds the position and a unit quaternion, seven numbers.

    Groups 2 i and 2 i + 1 of the pattern are position and rotation of node i.

    Attributes, beside those of every sparse body:
        beams: the elements, and the nodes at rest.
        mass: (n,) lumped mass [kg] and rotary inertia [kg m²] of the free degrees of freedom.
        tree: the elements outwards from the fixed nodes, along which nodes move; None: they form loops.
        beam_slot: places of the elements in the pattern.
        cable_slot: places of the segments of cables.
        force_slot: places of the rotations that forces, then transmissions turn.
        outer: forces on its points.
        surfaces: for contact and for drawing.
    """

    beams: Beams
    mass: Array
    tree: BeamTree | None
    beam_slot: tuple[Ints, Ints]
    cable_slot: tuple[Ints, Ints]
    force_slot: tuple[Ints, Ints]
    outer: OuterForces[AttachedPoints]
    surfaces: BeamSurfaces

    @property
    def of_beams(self) -> bool:
        """They are all that deforms, see `SparseBody`."""
        return True

    @property
    def n_nodes(self) -> int:
        """Nodes, fixed ones included."""
        return len(self.beams.nodes)

    @property
    def n_elements(self) -> int:
        """Beam elements."""
        return len(self.beams.ends)

    @property
    def moving_mass(self) -> float:
        """Mass of all nodes that are not fixed [kg]."""
        return float(self.mass[::6].sum())

    @property
    def size(self) -> float:
        """Largest distance between two nodes at rest [m], of the elements that can move.

        Steps of searches are bounded by shares of it, which an anchor far away must not make longer.
        """
        moving = self.beams.ends[(self.dof[self.beams.ends] >= 0).any(axis=1)]
        return diameter(self.beams.nodes[np.unique(moving)])

    @property
    def triangles(self) -> Ints:
        """Surface as triples of `points`: (t, 3)."""
        return self.surfaces.triangles

    @property
    def dof(self) -> Ints:
        """First of the six degrees of freedom of a node, −1 where it is fixed: (n_nodes,)."""
        return self.pattern.dof[::2]

    def loaded(
        self, gravity: Array, effector_force: Array, effectors: Effectors[AttachedPoints]
    ) -> BeamBody:
        """The body under other loads, see `Body`."""
        outer = effectors.pushed(effector_force)
        return dataclasses.replace(self, gravity=gravity, outer=outer)

    def rest(self) -> State:
        """The stress-free state at standstill."""
        free = self.beams.nodes[self.dof >= 0]
        q = np.hstack([free, np.tile([1.0, 0.0, 0.0, 0.0], (len(free), 1))])
        return State(q.ravel(), np.zeros(self.n))

    def pose(self, state: State) -> tuple[Array, Array]:
        """Positions (n_nodes, 3) [m] and rotations (n_nodes, 4) of all nodes."""
        free, q = self.dof >= 0, state.q.reshape(-1, 7)
        x, Q = self.beams.nodes.copy(), np.tile([1.0, 0.0, 0.0, 0.0], (self.n_nodes, 1))
        x[free], Q[free] = q[:, :3], q[:, 3:]
        return x, Q

    def motion(self, state: State) -> PoseMotion:
        """Where the nodes are at a state."""
        return PoseMotion(*self.pose(state), self.dof, self.n)

    def surface_points(self, vertices: Ints) -> AttachedPoints:
        """Points of the body at some vertices (v,) of its surfaces."""
        return self.surfaces.contact_points.at(vertices)

    def points(self, state: State) -> Array:
        """Positions of what `triangles` joins: (P, 3) [m]."""
        return self.surfaces.drawn_points.place(*self.pose(state))[0]

    def displacement(self, state: State, dq: Array) -> float:
        """Largest displacement of a node or of a point attached to it in a change dq (n,) [m]."""
        moved, turned = map(longest, dq.reshape(-1, 2, 3).swapaxes(0, 1))
        return max(moved, turned * self.surfaces.lever)

    def forces(
        self, state: State, effort: Array | None = None, exact: bool = False
    ) -> tuple[Array, Array]:
        """Internal and outer forces, and the tangent, see `Robot`."""
        motion, beams, dof = self.motion(state), self.beams, self.pattern.dof
        x, Q = motion.x, motion.Q
        force, K = np.zeros((2 * self.n_nodes, 3)), np.zeros(len(self.pattern.indices))
        force[::2] = np.outer(beams.mass, self.gravity)
        assemble_beams(x, Q, beams.arrays, exact, self.beam_slot, force, K)
        actuators = self.actuator_set
        efforts = actuators.efforts(effort)
        loads = actuators.loads(efforts, exact)
        if loads is not None:
            add_beam_cable_stiffness(
                *actuators.stations.place(x, Q), actuators.paths.segment_arrays,
                loads.tension, exact, self.cable_slot, K,
            )  # fmt: skip
            spread = actuators.spread(motion, loads)
            if exact and spread:
                arms = np.concatenate([points.place(x, Q)[1] for points, _ in spread])
                vectors = np.concatenate([part for _, part in spread])
                add_lever_stiffness(vectors, arms, self.force_slot, K)
            if actuators.transmissions is not None:
                actuators.transmissions.add_stiffness(motion, loads.transmitted, self.pattern, K)
        total = force[dof >= 0].ravel()
        preload = actuators.preload(motion)
        if preload is not None:
            total += preload[0]
        if self.outer:
            total += self.outer.on(motion)
        return total, K

    def stiffness(self, state: State) -> Array:
        """That of the beams alone, CSC values (nnz,): cables do not damp, see `SparseBody`."""
        motion, K = self.motion(state), np.zeros(len(self.pattern.indices))
        force = np.zeros((2 * self.n_nodes, 3))
        assemble_beams(motion.x, motion.Q, self.beams.arrays, False, self.beam_slot, force, K)
        return K

    def potential(self, state: State) -> float:
        """Elastic energy minus the work of gravity and outer forces since rest [J]."""
        motion, beams = self.motion(state), self.beams
        x, Q = motion.x, motion.Q
        force, K = np.zeros((2 * self.n_nodes, 3)), np.zeros(len(self.pattern.indices))
        energy = assemble_beams(x, Q, beams.arrays, False, self.beam_slot, force, K)
        weight = float(beams.mass @ ((x - beams.nodes) @ self.gravity))
        pushed = self.outer.work(motion, self.motion(self.rest())) if self.outer else 0.0
        preload = self.actuator_set.preload(motion)
        work = weight + pushed + (preload[1] if preload else 0.0)
        return energy - work

    def masses(self, state: State) -> Array:
        """Lumped masses and rotary inertias (n,), the same at any state."""
        return self.mass

    def velocity(self, start: State, end: State) -> Array:
        """The velocity (n,) that moves one state to another within a step [m/s, rad/s].

        Rotations of up to π in a step.
        """
        if self.tree is not None:
            step = step_along_arcs(*self.pose(start), *self.pose(end), self.tree.beams)
            along: Array = step[self.dof >= 0].ravel() / self.h
            return along
        first, last = start.q.reshape(-1, 7), end.q.reshape(-1, 7)
        turns = rotations_between(first[:, 3:].copy(), last[:, 3:].copy())
        v: Array = np.hstack([last[:, :3] - first[:, :3], turns]).ravel() / self.h
        return v

    def damping_at_end(self, start: StepStart, K: Array) -> Array:
        """Second derivative (nnz,) of ½ vᵀ C v by v h at the end of a step; it turns with the beams.

        See `Body`.
        """
        if self.tree is None:
            return start.damping
        damping: Array = self.integration.rayleigh_stiffness * K
        damping[self.pattern.diagonal] += self.integration.rayleigh_mass * self.mass
        return damping

    def at_end(self, start: State, end: State, force: Array) -> Array:
        """Forces (n,) at the end of a step that do the work of given ones at its start [N, N m].

        See `Body`.
        """
        if self.tree is not None:
            load = np.zeros((self.n_nodes, 6))
            load[self.dof >= 0] = force.reshape(-1, 6)
            beams = self.tree.beams
            at = forces_at_end(*self.pose(start), *self.pose(end), load, beams)
            return at[self.dof >= 0].ravel()
        found = force.reshape(-1, 6).copy()
        theta = self.h * self.velocity(start, end).reshape(-1, 6)[:, 3:]
        found[:, 3:] = moments_at_end(theta, found[:, 3:])
        return found.ravel()

    def advance(self, state: State, v: Array, h: float, straight: bool = False) -> State:
        """The state one step later, with the velocity v, nodes moved and turned by h v.

        Nodes of a tree move along arcs (`tauten.model.beams.arcs`). They move along straight lines where
        beams form loops, and in straight steps.

        Velocities are not turned with the nodes: inertia continues them along straight lines, and the forces
        of the next step curve the path. See `Robot`.
        """
        step, q = (h * v).reshape(-1, 6), state.q.reshape(-1, 7)
        if self.tree is None or straight:
            turned_by = turned(q[:, 3:].copy(), step[:, 3:].copy())
            return State(np.hstack([q[:, :3] + step[:, :3], turned_by]).ravel(), v)
        free, every = self.dof >= 0, np.zeros((self.n_nodes, 6))
        every[free] = step
        x, Q = self.pose(state)
        end, turns = moved_along_arcs(x, Q, every, self.tree.beams)
        return State(np.hstack([end[free], turns[free]]).ravel(), v)
