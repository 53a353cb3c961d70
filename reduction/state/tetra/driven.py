"""Robots of tetrahedra with drives and glue in reduced coordinates: modes, and the drives' own coordinates.

A rotation of a region about an axis a is linear in sin θ and 1 − cos θ,

    x = x₀ + sin θ a x ρ + (1 − cos θ) a x (a x ρ),                                           (T6)

so that all nodes are q₀ + E β with a constant E and β = (α, sin θ or travel, 1 − cos θ): modes α that leave
the regions of drives where they are, and the motion of the drives, exact at any angle. The body without
drives reduced to E gives forces f(β), tangents and rows; those in (α, θ) follow with J = ∂β/∂(α, θ): Jᵀ f
and H J.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, replace

import numpy as np

from tauten.model import Assembled, Integration, State, System
from tauten.model.constraints import ConstrainedRobot
from tauten.model.numerics import Array, Ints
from tauten.reduction.dense_step import DenseAssembled, implicit_system, scheme_of, shares_of
from tauten.reduction.reduced_robot import ElementSample, ReducedRobot, StateBasisError
from tauten.reduction.state.tetra.body import ModeMotion, ModePoints
from tauten.reduction.state.tetra.ecsw import sample_elements
from tauten.reduction.state.tetra.robot import ReducedTetRobot, ReducibleTetRobot, SampledAssembled


@dataclass(frozen=True, slots=True, eq=False)
class DriveMotion:
    """β and its derivatives by (α, θ).

    Attributes:
        modes: number of α.
        drives: m.
        turning: (t,) numbers of the drives that turn about their axes.
    """

    modes: int
    drives: int
    turning: Ints

    @property
    def size(self) -> int:
        """Length of β."""
        return self.modes + self.drives + len(self.turning)

    def beta(self, q: Array) -> Array:
        """β (R, …) of coordinates q (r + m, …), one state or several in columns."""
        theta = q[self.modes + self.turning]
        beta = np.concatenate([q, 1.0 - np.cos(theta)])
        beta[self.modes + self.turning] = np.sin(theta)
        return beta

    def jacobian(self, q: Array) -> Array:
        """J (R, r + m) at q (r + m,)."""
        columns = self.modes + self.turning
        J, theta = np.eye(self.size, len(q)), q[columns]
        J[columns, columns] = np.cos(theta)
        J[len(q) + np.arange(len(columns)), columns] = np.sin(theta)
        return J

    def bend(self, q: Array) -> Array:
        """∂²β/∂θ² of each drive: (m, R), two entries a row at most."""
        columns = self.modes + self.turning
        second, theta = np.zeros((self.drives, self.size)), q[columns]
        second[self.turning, columns] = -np.sin(theta)
        second[self.turning, len(q) + np.arange(len(columns))] = np.cos(theta)
        return second


@dataclass(frozen=True, slots=True, eq=False)
class DrivenAssembled(DenseAssembled):
    """Forces and tangents of a robot with drives at a state; attributes beside those of `DenseAssembled`.

    Attributes:
        body: those of the robot without drives, over β.
        motion: β there, and its derivative J by (α, θ).
    """

    body: SampledAssembled
    motion: ModeMotion


@dataclass(frozen=True, slots=True, eq=False)
class ReducedDrivenRobot(ReducedRobot[ModePoints]):
    """A reduced robot with drives. State.q has α and the angle or travel of each drive, State.v their rates.

    Attributes, beside those of every reduced robot:
        body: the robot without drives, reduced to β.
        drive_motion: β of the coordinates.
    """

    full: ConstrainedRobot
    body: ReducedTetRobot
    drive_motion: DriveMotion

    @property
    def n_elements(self) -> int:
        """Elements in the sample."""
        return self.body.n_elements

    def fork(self) -> ReducedDrivenRobot:
        """The same robot with a workspace of its own."""
        return dataclasses.replace(self, body=self.body.fork())

    def loaded(self, gravity: Array, effector_force: Array) -> ReducedDrivenRobot:
        """The robot under another gravity (3,) [m/s²] and forces on its effectors (3 p,) [N]."""
        full = self.full.loaded(gravity, effector_force)
        return dataclasses.replace(
            self,
            full=full,
            gravity=full.gravity,
            body=self.body.loaded(gravity, effector_force),
        )

    def lifted(self, state: State) -> State:
        """The state of the full robot."""
        Phi = self.Phi
        return State(self.full.rest().q + Phi @ state.q, Phi @ state.v)

    def projected(self, state: State) -> State:
        """The nearest state to one of the full robot, in the mass, with the same angles and travels."""
        project = self.Phi.T * ReducibleDrivenRobot(self.full).weight
        return State(project @ (state.q - self.full.rest().q), project @ state.v)

    def motion(self, state: State) -> ModeMotion:
        """Where the points of the body are at a state."""
        map_, q = self.drive_motion, state.q
        return ModeMotion(map_.beta(q), map_.jacobian(q), q[map_.modes :])

    def moved(self, state: State) -> State:
        """The state of `body`, at standstill."""
        beta = self.drive_motion.beta(state.q)
        return State(beta, np.zeros_like(beta))

    def displacement(self, state: State, dq: Array) -> float:
        """Largest displacement of an effector, contact vertex or driven node in a change dq (r + m,) [m]."""
        change = np.zeros(self.drive_motion.size)
        change[: len(dq)] = dq
        driven = np.abs(dq[self.drive_motion.modes :]) * self.full.frames.reach
        return max(
            self.body.displacement(self.moved(state), change), float(driven.max(initial=0.0))
        )

    def forces(
        self, state: State, effort: Array | None = None, exact: bool = False
    ) -> tuple[Array, Array]:
        """Forces without actuators and contacts (r + m,), and the tangent K (r + m, r + m).

        Args:
            state: where to evaluate.
            effort: (n_a,) efforts of the actuators, whose curvature enters the tangent.
            exact: the exact derivative, which is not always positive definite.
        """
        at = self.assemble(state, effort, replace(self.integration, static=True))
        return at.force, self.tangent(at, (0.0, 1.0), exact)

    def assemble(
        self, state: State, effort: Array | None = None, integration: Integration | None = None
    ) -> DrivenAssembled:
        """Forces and tangents at a state.

        Args:
            state: where steps start.
            effort: (n_a,) last efforts of the actuators.
            integration: another scheme than the robot's.
        """
        scheme, map_, motion = (
            integration or self.integration,
            self.drive_motion,
            self.motion(state),
        )
        J, mass, inertia = motion.J, np.zeros((0, 0)), np.zeros(self.n)
        assert J is not None
        moved = State(motion.beta, np.zeros(map_.size) if scheme.static else J @ state.v)
        body = self.body.assemble(moved, self.actuator_set.efforts(effort), scheme)
        if not scheme.static:
            centripetal = state.v[map_.modes :] ** 2 @ map_.bend(state.q)
            mass, inertia = J.T @ body.mass @ J, J.T @ (body.mass @ centripetal)
        force, preload = J.T @ body.force, self.actuator_set.preload(motion)
        if preload is not None:
            force = force + preload[0]
        resisting = J.T @ body.resisting
        return DrivenAssembled(state, effort, mass, force, inertia, resisting, body, motion)

    def tangent(self, at: DrivenAssembled, shares: tuple[float, float], exact: bool) -> Array:
        """A sum of the stiffness of the material and the tangent (r + m, r + m).

        Args:
            at: the state.
            shares: of D and of K.
            exact: whether K is the derivative, or positive semidefinite.
        """
        map_, body, J = self.drive_motion, at.body, at.motion.J
        assert J is not None
        tangent: Array = J.T @ self.body.tangent(body, shares, exact) @ J
        if exact and len(map_.turning) > 0:
            others, efforts = body.force, body.effort
            if efforts is not None and len(efforts) > 0:
                over_beta = self.body.motion(body.state)
                others = others + efforts @ self.body.actuator_set.rows(over_beta).dense()
            diagonal = np.einsum("ii->i", tangent)[map_.modes :]
            diagonal -= shares[1] * (map_.bend(at.state.q) @ others)
        return tangent

    def system(self, assembled: Assembled, integration: Integration) -> System:
        """The system of one step, see `ReducedRobot`."""
        assert isinstance(assembled, DrivenAssembled)
        at, scheme = assembled, scheme_of(integration)
        shares, L = shares_of(scheme), np.zeros((self.n, self.n))
        return implicit_system(scheme, at, lambda exact: self.tangent(at, shares, exact), L)


@dataclass(frozen=True, slots=True, eq=False)
class ReducibleDrivenRobot:
    """A robot with drives and glue as state reduction sees it.

    Deviations are displacements of the free nodes, orthonormal in their mass, and then the angle or travel of
    each drive, which are coordinates of their own.

    Attributes:
        robot: the robot, without rigid or pinned regions and beams.
    """

    robot: ConstrainedRobot

    @property
    def own_coordinates(self) -> int:
        """The drives, at the end of the deviations."""
        return self.robot.frames.n_drives

    @property
    def weight(self) -> Array:
        """Diagonal (n,) of M / m for the free nodes, one for each drive."""
        mass = self.robot.raw.mass.reshape(-1, 3)[self.robot.coordinates.free].ravel()
        return np.concatenate([3.0 * mass / mass.sum(), np.ones(self.own_coordinates)])

    @property
    def norm(self) -> str:
        """What W is, in a word."""
        return "mass"

    @property
    def default_motion(self) -> float:
        """Relative projection error that a basis is allowed, a share of all displacement."""
        return self.plain.default_motion

    @property
    def n_elements(self) -> int:
        """Number of integration points."""
        return self.plain.n_elements

    @property
    def plain(self) -> ReducibleTetRobot:
        """The body without drives and glue."""
        return ReducibleTetRobot(self.robot.raw)

    def deviations(self, q: Array) -> Array:
        """Displacements and coordinates of drives (n, s) of configurations (n, s) [m, rad]."""
        deviations: Array = q - self.robot.rest().q[:, None]
        return deviations

    def rates(self, q: Array, motion: Array) -> Array:
        """The velocities (n, k) themselves, at any configuration q (n,) [m/s, rad/s]."""
        return motion

    def sample(self, Phi: Array, alphas: Array, tolerance: float, seed: int) -> ElementSample:
        """A sample of integration points, see `sample_elements`.

        Args:
            Phi: (n, r + m) state modes, the last of which are the drives.
            alphas: (r + m, s) states of a campaign [m, rad].
            tolerance: relative residual.
            seed: of random directions.
        """
        E, motion = self.places(Phi)
        return sample_elements(self.robot.raw, E, motion.beta(alphas), tolerance, seed)

    def implausible(self, elements: Ints, weights: Array) -> str:
        """A sentence where the weighted elements have another volume than the body.

        Args:
            elements: (s,) numbers of integration points.
            weights: (s,) their weights.
        """
        return self.plain.implausible(elements, weights)

    def places(self, Phi: Array) -> tuple[Array, DriveMotion]:
        """E (3 n_nodes, R), displacements of all nodes that are not fixed, and the motion of β.

        Args:
            Phi: (n, r + m) state modes.

        Raises:
            StateBasisError: the last modes are not those of the drives.
        """
        map_, frames, m = self.robot.coordinates, self.robot.frames, self.own_coordinates
        r, first = Phi.shape[1] - m, 3 * len(map_.free)
        if r < 1 or not np.array_equal(Phi[first:], np.eye(m, r + m, r)) or Phi[:first, r:].any():
            raise StateBasisError(
                f"the last {m} modes are not the drives of robot {self.robot.name!r}: make the state basis "
                "again from its robot file with `tauten reduce --states`"
            )
        motion = DriveMotion(r, m, np.flatnonzero(frames.turns))
        E = np.zeros((map_.n_nodes, 3, motion.size))
        E[map_.free, :, :r] = Phi[:first, :r].reshape(-1, 3, r)
        second = r + m
        for drive, axis in enumerate(frames.axes):
            inside = frames.owner == drive
            nodes, arms = frames.nodes[inside], frames.offsets[inside]
            if not frames.turns[drive]:
                E[nodes, :, r + drive] = axis
                continue
            E[nodes, :, r + drive] = np.cross(axis, arms)
            E[nodes, :, second] = np.cross(axis, np.cross(axis, arms))
            second += 1
        flat = E.reshape(-1, motion.size)
        return np.ascontiguousarray(flat if map_.glue is None else map_.glue @ flat), motion

    def reduced(self, Phi: Array, elements: Ints, weights: Array) -> ReducedDrivenRobot:
        """The robot in the coordinates of a state basis.

        Args:
            Phi: (n, r + m) state modes, the last of which are the drives.
            elements: (s,) numbers of integration points, ascending.
            weights: (s,) their weights.

        Raises:
            StateBasisError: the last modes are not those of the drives.
        """
        E, motion = self.places(Phi)
        robot, body = self.robot, self.plain.reduced(E, elements, weights)
        drives = robot.actuator_set.drives
        actuators = dataclasses.replace(
            body.actuator_set,
            drives=dataclasses.replace(drives, columns=motion.modes + drives.travels),
            coupling=robot.actuator_set.coupling,
        )
        return ReducedDrivenRobot(
            names=robot.names,
            digest=robot.digest,
            gravity=robot.gravity,
            tolerance=robot.tolerance,
            integration=robot.integration,
            actuators=robot.actuators,
            actuator_set=actuators,
            limits=robot.limits,
            effectors=body.effectors,
            contacts=body.contacts,
            vertices=body.vertices,
            full=robot,
            Phi=Phi,
            body=body,
            drive_motion=motion,
        )
