"""A body of beams in reduced coordinates: its natural strains are Φ α.

The strain energy is quadratic in the natural strains, so with modes that are orthonormal in their
stiffnesses, Φᵀ D Φ = I, it is ½ |α|² and the elastic force is −α, without a sum over elements. Modes of
positions would stretch the beams where they bend; these modes do not. Large rotations are in the motion
(`tauten.model.beams.motion`): gravity, cables, contacts, effectors and the mass are those of the
full robot, multiplied by its J.

The tangent is Φᵀ D Φ, the curvature of taut cables, and the change of J under gravity, cables and outer
forces (`tauten.reduction.state.beams.loads`), a sum over a sample of elements: those that carry loads. Left
out are the change of J under contact forces, and accelerations that are quadratic in the velocity.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from tauten.model import Assembled, Augmentation, Integration, Robot, State, System
from tauten.model.actuators import Loads
from tauten.model.beams import BeamBody, BeamTree, follow
from tauten.model.numerics import Array, Ints, longest
from tauten.model.points import AttachedPoints, OuterForces, path_lengths
from tauten.reduction.dense_step import DenseAssembled, implicit_system
from tauten.reduction.reduced_body import ReducedBody
from tauten.reduction.state.beams.loads import (
    add_point_loads,
    effort_rows,
    load_rows,
    loads_beyond,
)
from tauten.reduction.state.beams.motion import point_motion
from tauten.reduction.state.beams.tree_motion import TreeMotion


@dataclass(slots=True, eq=False)
class BeamWork:
    """Workspace of a reduced robot of beams: the motion at one state, and the factors of the last system.

    Attributes:
        alpha: (r,) state the motion belongs to.
        motion: positions, rotations, and their derivatives; its arrays are overwritten.
        weighted: (6 n_nodes, r) J times the roots of the masses.
        Z, Y: (3 g, r) rows of the cable segments and their images.
        load_Y: (6 s, r) rows of the elements that carry loads, see `load_rows`.
        L: (r, r) Cholesky factor.
    """

    alpha: Array
    motion: TreeMotion
    weighted: Array
    Z: Array
    Y: Array
    load_Y: Array
    L: Array


@dataclass(frozen=True, slots=True, eq=False)
class BeamAssembled(DenseAssembled):
    """Forces and tangent of beams at a state: K (r, r) is the exact one."""

    K: Array


@dataclass(frozen=True, slots=True, eq=False)
class StrainBody(ReducedBody[AttachedPoints]):
    """A body of beams moved by modes of their strains.

    Attributes, beside those of every reduced body:
        tree: the elements.
        elements: (s,) numbers of the elements that carry loads.
        carrying: (6 s, r) their rows of Φ.
        stiffness: (r, r) Φᵀ D Φ.
        root_mass: (6 n_nodes,) square root of lumped mass [kg] and rotary inertia [kg m²].
        outer: forces on its points.
        cable: (s,) cable of each station.
        work: motion and factors.
    """

    full: Robot[BeamBody]
    tree: BeamTree
    elements: Ints
    carrying: Array
    stiffness: Array
    root_mass: Array
    outer: OuterForces[AttachedPoints]
    cable: Ints
    work: BeamWork

    @property
    def n_elements(self) -> int:
        """Elements in the sample."""
        return len(self.elements)

    def fork(self) -> StrainBody:
        """The same body with a workspace of its own."""
        work = make_beam_work(self.beams, self.Phi, len(self.elements))
        return dataclasses.replace(self, work=work)

    def of(self, full: Robot[BeamBody]) -> StrainBody:
        """The same reduction of a full robot under other loads."""
        return dataclasses.replace(self, full=full, gravity=full.gravity, outer=full.body.outer)

    @property
    def beams(self) -> BeamBody:
        """The full body."""
        return self.full.body

    def surface_points(self, vertices: Ints) -> AttachedPoints:
        """Points of the body at some vertices (v,) of its surfaces."""
        return self.beams.surface_points(vertices)

    def lifted(self, state: State) -> State:
        """The state of the full robot: nodes that follow the strains Φ α, and their velocities."""
        work, dof = self.moved(state.q), self.beams.dof
        q = np.hstack([work.motion.x[dof >= 0], work.motion.Q[dof >= 0]]).ravel()
        v: Array = (work.motion.J @ state.v).reshape(-1, 6)[dof >= 0].ravel()
        return State(q, v)

    def moved(self, alpha: Array) -> BeamWork:
        """The motion at a state (r,); computed where it is not that of the last call."""
        work = self.work
        if not np.logical_and.reduce(work.alpha == alpha):
            at = work.motion
            follow(self.Phi @ alpha, self.Phi, self.tree.beams, at.x, at.Q, at.J)
            work.alpha[:] = alpha
        return work

    def motion(self, state: State) -> TreeMotion:
        """Where the nodes are at a state."""
        return self.moved(state.q).motion

    def displacement(self, state: State, dq: Array) -> float:
        """Largest displacement of a node or a point attached to it in a change dq (r,), about [m]."""
        J = self.moved(state.q).motion.J
        moved, turned = map(longest, (J @ dq).reshape(-1, 2, 3).swapaxes(0, 1))
        return max(moved, turned * self.beams.surfaces.lever)

    def potential(self, state: State) -> float:
        """Strain energy minus the work of gravity and outer forces since rest [J]."""
        full, work = self.beams, self.moved(state.q)
        fallen = full.beams.mass @ (work.motion.x - full.beams.nodes) @ full.gravity
        outer, placed = self.outer.points, work.motion.placed(self.outer.points)
        pushed = np.vdot(self.outer.vectors, placed.y - outer.at_rest(full.beams.nodes))
        preload = self.actuator_set.preload(work.motion)
        work_done = fallen + pushed + (0.0 if preload is None else preload[1])
        return float(0.5 * state.q @ self.stiffness @ state.q - work_done)

    def masses(self, state: State) -> Array:
        """The mass matrix Jᵀ M J (r, r) at a state."""
        return self.projected_mass(self.moved(state.q))

    def forces(
        self, state: State, effort: Array | None = None, exact: bool = False
    ) -> tuple[Array, Array]:
        """Forces without actuators and contacts (r,), and the tangent K (r, r), see `Robot`."""
        work, full = self.moved(state.q), self.beams
        force = self.mass_rows(full.gravity) @ work.motion.J - self.stiffness @ state.q
        if self.outer:
            force += self.outer.on(work.motion)
        preload = self.actuator_set.preload(work.motion)
        if preload is not None:
            force += preload[0]
        actuators = self.actuator_set
        return force, self.tangent(work, actuators.loads(actuators.efforts(effort), exact), exact)

    def material_stiffness(self, state: State) -> Array:
        """Φᵀ D Φ (r, r), whatever the state."""
        return self.stiffness

    def mass_rows(self, acceleration: Array) -> Array:
        """Forces on all nodes (6 n_nodes,) under an acceleration (3,) of the whole body [N]."""
        load = np.zeros((self.beams.n_nodes, 6))
        load[:, :3] = np.outer(self.beams.beams.mass, acceleration)
        return load.ravel()

    def tangent(self, work: BeamWork, loads: Loads | None, exact: bool) -> Array:
        """The tangent K (r, r), see `forces`."""
        full, actuators = self.beams, self.actuator_set
        K = self.stiffness.copy()
        force, moment = np.zeros((full.n_nodes, 3)), np.zeros((full.n_nodes, 3, 3))
        if loads is not None:
            stations, paths = actuators.stations, actuators.paths
            points, arms = stations.place(work.motion.x, work.motion.Q)
            motion = point_motion(stations.nodes, stations.weights, arms, work.motion.J)
            effort_rows(points, paths.segment_arrays, loads.tension, motion, work.Z, work.Y)
            K += work.Z.T @ work.Y
            _, positions = path_lengths(points, paths.starts, paths.shortest)
            along = loads.tension[self.cable][:, None] * positions
            add_point_loads(along, stations.nodes, stations.weights, arms, force, moment)
            for held, vectors in actuators.spread(work.motion, loads):
                _, arms = held.place(work.motion.x, work.motion.Q)
                add_point_loads(vectors, held.nodes, held.weights, arms, force, moment)
            if exact and actuators.transmissions is not None:
                K += actuators.transmissions.stiffness(work.motion, loads.transmitted)
        if not exact:
            return K
        force += np.outer(full.beams.mass, full.gravity)
        if self.outer:
            held = self.outer.points
            _, arms = held.place(work.motion.x, work.motion.Q)
            add_point_loads(self.outer.vectors, held.nodes, held.weights, arms, force, moment)
        beyond = np.empty_like(force), np.empty_like(moment)
        loads_beyond(force, moment, work.motion.x, self.tree.beams.ends, *beyond)
        strains, Y = self.Phi @ work.alpha, work.load_Y
        load_rows(
            strains,
            self.tree.beams,
            self.elements,
            work.motion.Q,
            beyond,
            self.Phi,
            work.motion.J,
            Y,
        )
        product = self.carrying.T @ Y
        K -= product + product.T
        return K

    def assemble(
        self, state: State, effort: Array | None = None, integration: Integration | None = None
    ) -> BeamAssembled:
        """Forces and tangent at a state, see `Body`."""
        scheme, work = integration or self.integration, self.moved(state.q)
        mass = np.zeros((0, 0)) if scheme.static else self.projected_mass(work)
        force, K = self.forces(state, effort, exact=True)
        resisting = np.zeros(self.n) if scheme.static else self.stiffness @ state.v
        return BeamAssembled(state, effort, mass, force, None, resisting, K)

    def system(
        self, assembled: Assembled, integration: Integration, added: Augmentation = None
    ) -> System:
        """The system of one step, see `Body`."""
        assert isinstance(assembled, BeamAssembled)
        at, (of_D, of_K) = assembled, integration.shares
        effort = at.effort if integration.static else None  # see `SparseBody.semidefinite`

        def stiffness(exact: bool) -> Array:
            K = at.K if exact else self.forces(at.state, effort)[1]
            return of_D * self.stiffness + of_K * K

        def material() -> Array:
            return (of_D + of_K) * self.stiffness

        return implicit_system(integration, at, stiffness, material, self.work.L, added=added)

    def projected_mass(self, work: BeamWork) -> Array:
        """The mass Jᵀ M J (r, r)."""
        np.multiply(self.root_mass[:, None], work.motion.J, out=work.weighted)
        mass: Array = work.weighted.T @ work.weighted  # one factor twice: half the work
        return mass


def make_beam_work(body: BeamBody, Phi: Array, n_elements: int) -> BeamWork:
    """A workspace; its motion belongs to no state yet.

    Args:
        body: the full body.
        Phi: (6 e, r) strain modes.
        n_elements: elements in the sample.
    """
    r, segments = Phi.shape[1], len(body.actuator_set.paths.first)
    x, Q = body.pose(body.rest())
    return BeamWork(
        alpha=np.full(r, np.nan),
        motion=TreeMotion(x, Q, np.zeros((6 * body.n_nodes, r))),
        weighted=np.empty((6 * body.n_nodes, r)),
        Z=np.empty((3 * segments, r)),
        Y=np.empty((3 * segments, r)),
        load_Y=np.empty((6 * n_elements, r)),
        L=np.zeros((r, r)),
    )


def make_reduced(
    robot: Robot[BeamBody], tree: BeamTree, Phi: Array, elements: Ints
) -> Robot[StrainBody]:
    """A robot of beams in the coordinates of strain modes.

    Args:
        robot: the full robot.
        tree: its elements.
        Phi: (6 e, r) strain modes.
        elements: (s,) elements that carry loads, at which the change of J is evaluated.
    """
    full = robot.body
    mass, paths = np.zeros((full.n_nodes, 6)), full.actuator_set.paths
    mass[:, :3], mass[:, 3:] = full.beams.mass[:, None], full.beams.inertia[:, None]
    rows = (6 * elements[:, None] + np.arange(6)).ravel()
    body = StrainBody(
        gravity=full.gravity,
        integration=full.integration,
        actuator_set=full.actuator_set,
        full=robot,
        Phi=np.ascontiguousarray(Phi),
        tree=tree,
        elements=elements,
        carrying=Phi[rows],
        stiffness=Phi.T @ (tree.D[:, None] * Phi),
        root_mass=np.sqrt(mass.ravel()),
        outer=full.outer,
        cable=np.repeat(np.arange(paths.n_a), np.diff(paths.starts)),
        work=make_beam_work(full, Phi, len(elements)),
    )
    return robot.with_body(body, robot.effectors, robot.contacts, robot.vertices)
