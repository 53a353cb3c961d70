"""A robot of tetrahedra in reduced coordinates: no array of a step is as long as its mesh.

q = q₀ + Φ α (14). State.q is α, State.v its rate. Forces and tangent are sums over a sample of elements,
directly in α (`tauten.reduction.state.tetra.kernels`); contact vertices, cable stations and effectors move
with their rows of Φ, multiplied with the weights once.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from tauten.model import Assembled, Integration, State, System, TetRobot
from tauten.model.effectors import Effectors
from tauten.model.numerics import Array, Ints
from tauten.reduction.dense_step import DenseAssembled, implicit_system, scheme_of, shares_of
from tauten.reduction.reduced_robot import ElementSample, ReducedRobot
from tauten.reduction.state.tetra.actuators import (
    ModalCurvature,
    modal_curvature,
    reduced_actuators,
)
from tauten.reduction.state.tetra.arrays import Body, Response, Work, make_work
from tauten.reduction.state.tetra.body import (
    ModeMotion,
    ModePoints,
    contact_surface,
    mode_points,
    sampled_body,
)
from tauten.reduction.state.tetra.ecsw import sample_elements
from tauten.reduction.state.tetra.elements import assemble_response
from tauten.reduction.state.tetra.kernels import combine
from tauten.reduction.state.tetra.points import integration_points

_VOLUME = (
    2.0  # factor between the volume of the weighted elements and the body's; samples reach 1.02
)


@dataclass(frozen=True, slots=True, eq=False)
class SampledAssembled(DenseAssembled):
    """Forces and tangents of sampled elements at a state; attributes beside those of `DenseAssembled`.

    Attributes:
        tension: of each cable [N].
        response: of the elements, in the workspace of the robot that assembled it.
        damped: whether it has the stiffness of the material.
    """

    tension: Array
    response: Response
    damped: bool


@dataclass(frozen=True, slots=True, eq=False)
class ReducedTetRobot(ReducedRobot[ModePoints]):
    """A reduced robot made of tetrahedra.

    Attributes, beside those of every reduced robot:
        body: sampled elements.
        curvature: of its cables and chambers.
        mass: (r, r) Φᵀ M Φ [kg].
        load: (r,) Φᵀ of gravity and outer forces [N].
        effector_places: (3 p, r) displacement of the effectors, where outer forces act on them.
        work: workspace of the kernels.
    """

    full: TetRobot
    body: Body
    curvature: ModalCurvature
    mass: Array
    load: Array
    effector_places: Array
    work: Work

    @property
    def n_elements(self) -> int:
        """Elements in the sample."""
        return self.body.elements

    def fork(self) -> ReducedTetRobot:
        """The same robot with a workspace of its own."""
        return dataclasses.replace(self, work=make_work(self.body, self.curvature.tendons))

    def loaded(self, gravity: Array, effector_force: Array) -> ReducedTetRobot:
        """The robot under another gravity (3,) [m/s²] and forces on its effectors (3 p,) [N]."""
        full = self.full.loaded(gravity, effector_force)
        return dataclasses.replace(
            self, full=full, gravity=full.gravity, load=self.Phi.T @ full.load
        )

    def lifted(self, state: State) -> State:
        """The state of the full robot: q₀ + Φ α, Φ v."""
        Phi = self.Phi
        return State(self.full.rest().q + Phi @ state.q, Phi @ state.v)

    def projected(self, state: State) -> State:
        """The nearest state to one of the full robot, in the mass."""
        weight = 3.0 * self.full.mass / self.full.mass.sum()  # (n,)
        Phi = self.Phi
        return State(Phi.T @ (weight * (state.q - self.full.rest().q)), Phi.T @ (weight * state.v))

    def motion(self, state: State) -> ModeMotion:
        """Where the points of the body are at a state."""
        return ModeMotion(state.q, None, np.zeros(0))

    def displacement(self, state: State, dq: Array) -> float:
        """Largest displacement of an effector or contact vertex in a change dq (r,) [m]."""
        parts = (self.effector_places @ dq, self.vertices.map @ dq)
        return max(float(np.abs(part).max(initial=0.0)) for part in parts)

    def forces(
        self, state: State, effort: Array | None = None, exact: bool = False
    ) -> tuple[Array, Array]:
        """Forces without actuators and contacts (r,) [N], and the tangent K (r, r).

        Args:
            state: where to evaluate.
            effort: (n_a,) efforts of the actuators, whose curvature enters the tangent.
            exact: the exact derivative, which is not always positive definite.
        """
        at = self.assemble(state, effort, dataclasses.replace(self.integration, static=True))
        return at.force, self.tangent(at, (0.0, 1.0), exact)

    def assemble(
        self, state: State, effort: Array | None = None, integration: Integration | None = None
    ) -> SampledAssembled:
        """Forces and tangents at a state.

        Args:
            state: where steps start.
            effort: (n_a,) last efforts of the actuators.
            integration: another scheme than the robot's.
        """
        scheme, response = integration or self.integration, self.work.response
        actuators, alpha = self.actuator_set, state.q
        efforts = actuators.efforts(effort)
        loads = actuators.loads(np.zeros(self.n_a) if efforts is None else efforts, exact=True)
        assert loads is not None
        self.curvature.write(alpha, loads.pressure, response.curvature)
        preload = actuators.preload(self.motion(state))
        load = self.load if preload is None else self.load + preload[0]
        damped = not scheme.static and scheme.rayleigh_stiffness > 0.0
        assemble_response(alpha, state.v, load, damped, self.body, response)
        return SampledAssembled(
            state, effort, self.mass, response.force.copy(), np.zeros(self.n),
            response.resisting.copy(), loads.tension, response, damped,
        )  # fmt: skip

    def tangent(self, at: SampledAssembled, shares: tuple[float, float], exact: bool) -> Array:
        """A sum of the stiffness of the material and the tangent (r, r), in the workspace.

        Args:
            at: the state.
            shares: of D and of K.
            exact: whether K is the derivative, or positive semidefinite.
        """
        if not (exact or at.damped or self.body.corotational):
            assemble_response(at.state.q, at.state.v, self.load, True, self.body, at.response)
        tendons = self.curvature.tendons
        combine(
            at.state.q, at.tension, shares, exact, at.response, self.body, tendons, self.work
        )  # fmt: skip
        return self.work.S.copy()

    def system(self, assembled: Assembled, integration: Integration) -> System:
        """The system of one step, see `ReducedRobot`."""
        assert isinstance(assembled, SampledAssembled)
        at, scheme = assembled, scheme_of(integration)
        shares = shares_of(scheme)
        return implicit_system(
            scheme, at, lambda exact: self.tangent(at, shares, exact), self.work.L
        )


@dataclass(frozen=True, slots=True, eq=False)
class ReducibleTetRobot:
    """A robot made of tetrahedra as state reduction sees it: deviations are displacements.

    Modes are orthonormal in the mass, Φᵀ M Φ = m I with the body's mass m, so α is in metres and |α| is the
    root mean square displacement of the body. Fixed nodes have no rows in Φ, so they do not move.

    Attributes:
        robot: the robot.
    """

    robot: TetRobot

    @property
    def own_coordinates(self) -> int:
        """None: all displacements are those of modes."""
        return 0

    @property
    def weight(self) -> Array:
        """Diagonal (n,) of M / m."""
        weight: Array = (
            3.0 * self.robot.mass / self.robot.mass.sum()
        )  # every node counts three times
        return weight

    @property
    def norm(self) -> str:
        """What W is, in a word."""
        return "mass"

    @property
    def default_motion(self) -> float:
        """Relative projection error that a basis is allowed, a share of all displacement."""
        return 5e-5

    @property
    def n_elements(self) -> int:
        """Number of integration points."""
        return len(integration_points(self.robot))

    def deviations(self, q: Array) -> Array:
        """Displacements (n, s) of configurations (n, s) [m]."""
        displacements: Array = q - self.robot.rest().q[:, None]
        return displacements

    def rates(self, q: Array, motion: Array) -> Array:
        """The velocities (n, k) themselves, at any configuration q (n,) [m/s]."""
        return motion

    def sample(self, Phi: Array, alphas: Array, tolerance: float, seed: int) -> ElementSample:
        """A sample of integration points, see `sample_elements`.

        Args:
            Phi: (n, r) state modes.
            alphas: (r, s) states of a campaign [m].
            tolerance: relative residual.
            seed: of random directions.
        """
        return sample_elements(self.robot, Phi, alphas, tolerance, seed)

    def implausible(self, elements: Ints, weights: Array) -> str:
        """A sentence where the weighted elements have another volume than the body.

        Args:
            elements: (s,) numbers of integration points.
            weights: (s,) their weights.
        """
        volume = integration_points(self.robot).volume
        with np.errstate(over="ignore"):
            share = float(weights @ volume[elements] / volume.sum())
        if 1.0 / _VOLUME <= share <= _VOLUME:
            return ""
        return (
            f"the weighted elements of this state basis have {share:.3g} times the volume of "
            f"robot {self.robot.name!r}, allowed are {1.0 / _VOLUME} to {_VOLUME}"
        )

    def reduced(self, Phi: Array, elements: Ints, weights: Array) -> ReducedTetRobot:
        """The robot in the coordinates of a state basis.

        Args:
            Phi: (n, r) state modes.
            elements: (s,) numbers of integration points, ascending.
            weights: (s,) their weights.
        """
        robot = self.robot
        body, curvature = sampled_body(robot, Phi, elements, weights), modal_curvature(robot, Phi)
        surface, contacts = contact_surface(robot, Phi)
        places = robot.effectors.places(robot.motion(robot.rest()))
        points = mode_points(robot, Phi, robot.effectors.points)
        return ReducedTetRobot(
            names=robot.names,
            digest=robot.digest,
            gravity=robot.gravity,
            tolerance=robot.tolerance,
            integration=robot.integration,
            actuators=robot.actuators,
            actuator_set=reduced_actuators(robot, Phi),
            limits=robot.limits,
            effectors=Effectors(robot.effectors.kinds, points),
            contacts=contacts,
            vertices=surface,
            full=robot,
            Phi=Phi,
            body=body,
            curvature=curvature,
            mass=Phi.T @ (robot.mass[:, None] * Phi),
            load=Phi.T @ robot.load,
            effector_places=np.asarray(places.H @ Phi),
            work=make_work(body, curvature.tendons),
        )
