"""A robot of beams in reduced coordinates: its natural strains are Φ α.

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

from tauten.model import (
    Assembled,
    ChainedRows,
    ContactRows,
    EffectorRows,
    Integration,
    RobotRows,
    Rows,
    State,
    System,
)
from tauten.model.actuators import motor_rows
from tauten.model.beams import BeamRobot, BeamTree, follow
from tauten.model.contact import gap_entries
from tauten.model.numerics import Array, Ints
from tauten.model.points import AttachedPoints, Entries, coordinates, path_lengths
from tauten.reduction.dense_step import DenseAssembled, implicit_system, scheme_of, shares_of
from tauten.reduction.reduced_robot import ReducedRobot
from tauten.reduction.state.beams.loads import (
    add_point_loads,
    effort_rows,
    load_rows,
    loads_beyond,
)
from tauten.reduction.state.beams.motion import point_motion, point_rows


@dataclass(slots=True, eq=False)
class BeamWork:
    """Workspace of a reduced robot of beams: the motion at one state, and the factors of the last system.

    Attributes:
        alpha: (r,) state the motion belongs to.
        x: (n_nodes, 3) positions [m].
        Q: (n_nodes, 4) rotations.
        J: (6 n_nodes, r) their derivatives.
        weighted: (6 n_nodes, r) J times the roots of the masses.
        Z, Y: (3 g, r) rows of the cable segments and their images.
        load_Y: (6 s, r) rows of the elements that carry loads, see `load_rows`.
        L: (r, r) Cholesky factor.
    """

    alpha: Array
    x: Array
    Q: Array
    J: Array
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
class ReducedBeamRobot(ReducedRobot):
    """A reduced robot made of beams.

    Attributes, beside those of every reduced robot:
        tree: the elements.
        elements: (s,) numbers of the elements that carry loads.
        carrying: (6 s, r) their rows of Φ.
        stiffness: (r, r) Φᵀ D Φ.
        mass: (6 n_nodes,) lumped mass [kg] and rotary inertia [kg m²].
        root_mass: (6 n_nodes,) its square root.
        outer: (P, 3) outer forces on the points of the effectors [N].
        cable: (s,) cable of each station.
        all_dof: (n_nodes,) first row of each node in J, fixed ones included.
        work: motion and factors.
    """

    full: BeamRobot
    tree: BeamTree
    elements: Ints
    carrying: Array
    stiffness: Array
    mass: Array
    root_mass: Array
    outer: Array
    cable: Ints
    all_dof: Ints
    work: BeamWork

    @property
    def n_elements(self) -> int:
        """Elements in the sample."""
        return len(self.elements)

    def fork(self) -> ReducedBeamRobot:
        """The same robot with a workspace of its own."""
        return dataclasses.replace(
            self, work=make_beam_work(self.full, self.Phi, len(self.elements))
        )

    def loaded(self, gravity: Array, effector_force: Array) -> ReducedBeamRobot:
        """The robot under another gravity (3,) [m/s²] and forces on its effectors (3 p,) [N]."""
        full = self.full.loaded(gravity, effector_force)
        return dataclasses.replace(self, full=full, outer=outer_forces(full))

    def lifted(self, state: State) -> State:
        """The state of the full robot: nodes that follow the strains Φ α, and their velocities."""
        work, dof = self.moved(state.q), self.full.dof
        q = np.hstack([work.x[dof >= 0], work.Q[dof >= 0]]).ravel()
        v: Array = (work.J @ state.v).reshape(-1, 6)[dof >= 0].ravel()
        return State(q, v)

    def projected(self, state: State) -> State:
        """The nearest state to one of the full robot: strains in their energy, velocities in the mass."""
        alpha = self.Phi.T @ (self.tree.D * self.tree.strains(*self.full.pose(state)))
        J, v = self.moved(alpha).J, np.zeros((self.full.n_nodes, 6))
        v[self.full.dof >= 0] = state.v.reshape(-1, 6)
        weighted = self.mass[:, None] * J
        rate = np.linalg.solve(J.T @ weighted, weighted.T @ v.ravel())
        return State(alpha, rate.astype(float))

    def moved(self, alpha: Array) -> BeamWork:
        """The motion at a state (r,); computed where it is not that of the last call."""
        work = self.work
        if not np.array_equal(work.alpha, alpha):
            follow(self.Phi @ alpha, self.Phi, self.tree.beams, work.x, work.Q, work.J)
            work.alpha[:] = alpha
        return work

    def effector(self, state: State) -> Array:
        """Positions of the effectors: (p, 3) [m]."""
        work = self.moved(state.q)
        return self.full.effectors.positions(work.x, work.Q)

    def effector_values(self, state: State) -> Array:
        """Goal values of the effectors: (n_v,)."""
        work = self.moved(state.q)
        return self.full.effectors.values(work.x, work.Q)

    def candidates(self, state: State) -> Array:
        """Positions of the contact candidates: (n_c, 3) [m]."""
        full, work = self.full, self.moved(state.q)
        return full.contacts.positions(full.surfaces.contact_points.place(work.x, work.Q)[0])

    def displacement(self, state: State, dq: Array) -> float:
        """Largest displacement of a node or a point attached to it in a change dq (r,), about [m]."""
        J = self.moved(state.q).J
        moved, turned = np.abs((J @ dq).reshape(-1, 2, 3)).max(axis=(0, 2), initial=0.0)
        return float(max(moved, turned * self.full.surfaces.lever))

    def potential(self, state: State) -> float:
        """Strain energy minus the work of gravity and outer forces since rest [J]."""
        full, work = self.full, self.moved(state.q)
        fallen = full.body.mass @ (work.x - full.body.nodes) @ full.gravity
        pushed = np.vdot(self.outer, full.effectors.points.place(work.x, work.Q)[0])
        return float(0.5 * state.q @ self.stiffness @ state.q - fallen - pushed)

    def forces(
        self, state: State, effort: Array | None = None, exact: bool = False
    ) -> tuple[Array, Array]:
        """Forces without actuators and contacts (r,), and the tangent K (r, r).

        Args:
            state: where to evaluate.
            effort: (n_a,) efforts of the actuators, whose curvature enters the tangent.
            exact: with the terms that stress brings, which may make the tangent indefinite.
        """
        work, full = self.moved(state.q), self.full
        force = self.mass_rows(full.gravity) @ work.J - self.stiffness @ state.q
        if self.outer.any():
            points = full.effectors.points
            force += self.outer.ravel() @ placed_on_tree(points, work).motion()
        coupling = full.actuator_set.coupling
        if coupling is None:
            return force, self.tangent(work, effort, exact)
        if coupling.is_preloaded:
            force += coupling.offsets @ self.cable_rows(work).dense()
        motors = np.zeros(self.n_a) if effort is None else effort
        return force, self.tangent(work, coupling.efforts(motors), exact)

    def mass_rows(self, acceleration: Array) -> Array:
        """Forces on all nodes (6 n_nodes,) under an acceleration (3,) of the whole body [N]."""
        load = np.zeros((self.full.n_nodes, 6))
        load[:, :3] = np.outer(self.full.body.mass, acceleration)
        return load.ravel()

    def tangent(self, work: BeamWork, effort: Array | None, exact: bool) -> Array:
        """The tangent K (r, r), see `forces`.

        Args:
            work: motion at the state.
            effort: of each cable [N], or None.
            exact: with the terms that loads bring.
        """
        full, cables = self.full, self.full.actuator_set.cables
        K = self.stiffness.copy()
        force, moment = np.zeros((full.n_nodes, 3)), np.zeros((full.n_nodes, 3, 3))
        if effort is not None:
            stations = cables.stations
            points, arms = stations.place(work.x, work.Q)
            motion = point_motion(stations.nodes, stations.weights, arms, work.J)
            used = effort if exact else np.maximum(effort, 0.0)  # rods that push soften
            effort_rows(points, cables.paths.segment_arrays, used, motion, work.Z, work.Y)
            K += work.Z.T @ work.Y
            _, positions = path_lengths(points, cables.paths.starts, cables.paths.shortest)
            along = effort[self.cable][:, None] * positions
            add_point_loads(along, stations.nodes, stations.weights, arms, force, moment)
        if not exact:
            return K
        force += np.outer(full.body.mass, full.gravity)
        if self.outer.any():
            held = full.effectors.points
            _, arms = held.place(work.x, work.Q)
            add_point_loads(self.outer, held.nodes, held.weights, arms, force, moment)
        loads = np.empty_like(force), np.empty_like(moment)
        loads_beyond(force, moment, work.x, self.tree.beams.ends, *loads)
        strains, Y = self.Phi @ work.alpha, work.load_Y
        load_rows(strains, self.tree.beams, self.elements, work.Q, loads, self.Phi, work.J, Y)
        product = self.carrying.T @ Y
        K -= product + product.T
        return K

    def assemble(
        self, state: State, effort: Array | None = None, integration: Integration | None = None
    ) -> BeamAssembled:
        """Forces and tangent at a state.

        Args:
            state: where steps start.
            effort: (n_a,) last efforts of the actuators.
            integration: another scheme than the robot's.
        """
        scheme, work, still = integration or self.integration, self.moved(state.q), np.zeros(self.n)
        mass = np.zeros((0, 0)) if scheme.static else self.projected_mass(work)
        force, K = self.forces(state, effort, exact=True)
        resisting = still if scheme.static else self.stiffness @ state.v
        return BeamAssembled(state, effort, mass, force, still, resisting, K)

    def system(self, assembled: Assembled, integration: Integration) -> System:
        """The system of one step, see `ReducedRobot`."""
        assert isinstance(assembled, BeamAssembled)
        at, scheme = assembled, scheme_of(integration)
        of_D, of_K = shares_of(scheme)

        def stiffness(exact: bool) -> Array:
            K = at.K if exact else self.forces(at.state, at.effort)[1]
            return of_D * self.stiffness + of_K * K

        return implicit_system(scheme, at, stiffness, self.work.L)

    def projected_mass(self, work: BeamWork) -> Array:
        """The mass Jᵀ M J (r, r)."""
        np.multiply(self.root_mass[:, None], work.J, out=work.weighted)
        mass: Array = work.weighted.T @ work.weighted  # one factor twice: half the work
        return mass

    def rows(self, state: State, contacts: bool = True) -> RobotRows:
        """Rows of effectors, actuators and, where `contacts` is true, contacts at this state."""
        work, coupling = self.moved(state.q), self.full.actuator_set.coupling
        nothing = ContactRows.out_of_range(np.zeros((0, self.n)), self.n_c)
        return RobotRows(
            effectors=self.effector_rows(work),
            actuators=motor_rows(coupling, self.cable_rows(work)),
            contacts=self.contact_rows(work) if contacts else nothing,
        )

    def cable_rows(self, work: BeamWork) -> Rows:
        """Pulled lengths of the single cables."""
        cables = self.full.actuator_set.cables
        return cables.paths.rows(placed_on_tree(cables.stations, work))

    def effector_rows(self, work: BeamWork) -> EffectorRows:
        """Rows of the effectors."""
        effectors = self.full.effectors
        return effectors.kinds.rows(placed_on_tree(effectors.points, work))

    def contact_rows(self, work: BeamWork) -> ContactRows:
        """Gaps of the candidates in range."""
        surface, nodes = self.full.surfaces.contact_points, self.full.n_nodes
        placed = surface.placed(work.x, work.Q, self.all_dof, 6 * nodes)
        found = self.full.contacts.detect(placed.y)
        S = placed.rows(gap_entries(found))
        rows = ChainedRows(S.indptr, S.indices, S.data, work.J, found.gap)
        return ContactRows(rows, found)


@dataclass(frozen=True, slots=True)
class PlacedOnTree:
    """Attached points at one state of beams whose natural strains are the unknowns.

    Attributes:
        y: (p, 3) positions [m].
        arms: (p, 2, 3) weighted lever arms [m].
        points: the points.
        J: (6 n_nodes, r) motion of the nodes.
    """

    y: Array
    arms: Array
    points: AttachedPoints
    J: Array

    def rows(self, entries: Entries) -> Array:
        """Rows (m, r) over the unknowns, of rows over these points."""
        found: Array = point_rows(
            entries.starts, entries.points, entries.vectors,
            self.points.nodes, self.points.weights, self.arms, self.J,
        )  # fmt: skip
        return found

    def motion(self) -> Array:
        """Derivative of the positions by the unknowns: (3 p, n)."""
        return self.rows(coordinates(len(self.y)))


def placed_on_tree(points: AttachedPoints, work: BeamWork) -> PlacedOnTree:
    """Attached points at the state of a motion."""
    return PlacedOnTree(*points.place(work.x, work.Q), points, work.J)


def outer_forces(robot: BeamRobot) -> Array:
    """Outer forces on the points of the effectors: (P, 3) [N]."""
    forces = robot.effector_force.reshape(-1, 3)
    parts = [
        np.outer(measure.carrier, force)
        for measure, force in zip(robot.effectors.kinds.measures, forces, strict=True)
    ]
    return np.concatenate(parts)


def make_beam_work(robot: BeamRobot, Phi: Array, n_elements: int) -> BeamWork:
    """A workspace; its motion belongs to no state yet.

    Args:
        robot: the full robot.
        Phi: (6 e, r) strain modes.
        n_elements: elements in the sample.
    """
    r, segments = Phi.shape[1], len(robot.actuator_set.cables.paths.first)
    x, Q = robot.pose(robot.rest())
    return BeamWork(
        alpha=np.full(r, np.nan),
        x=x,
        Q=Q,
        J=np.zeros((6 * robot.n_nodes, r)),
        weighted=np.empty((6 * robot.n_nodes, r)),
        Z=np.empty((3 * segments, r)),
        Y=np.empty((3 * segments, r)),
        load_Y=np.empty((6 * n_elements, r)),
        L=np.zeros((r, r)),
    )


def make_reduced(robot: BeamRobot, tree: BeamTree, Phi: Array, elements: Ints) -> ReducedBeamRobot:
    """A robot of beams in the coordinates of strain modes.

    Args:
        robot: the full robot.
        tree: its elements.
        Phi: (6 e, r) strain modes.
        elements: (s,) elements that carry loads, at which the change of J is evaluated.
    """
    mass, cables = np.zeros((robot.n_nodes, 6)), robot.actuator_set.cables
    mass[:, :3], mass[:, 3:] = robot.body.mass[:, None], robot.body.inertia[:, None]
    rows = (6 * elements[:, None] + np.arange(6)).ravel()
    return ReducedBeamRobot(
        full=robot,
        Phi=np.ascontiguousarray(Phi),
        integration=robot.integration,
        tree=tree,
        elements=elements,
        carrying=Phi[rows],
        stiffness=Phi.T @ (tree.D[:, None] * Phi),
        mass=mass.ravel(),
        root_mass=np.sqrt(mass.ravel()),
        outer=outer_forces(robot),
        cable=np.repeat(np.arange(cables.n_a), np.diff(cables.paths.starts)),
        all_dof=6 * np.arange(robot.n_nodes),
        work=make_beam_work(robot, Phi, len(elements)),
    )
