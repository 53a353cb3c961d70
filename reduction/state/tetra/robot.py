"""A robot of tetrahedra in reduced coordinates: no array of a step is as long as its mesh.

q = q₀ + Φ α (14). State.q is α, State.v its rate. Forces and tangent are sums over a sample of elements,
directly in α (`tauten.reduction.state.tetra.kernels`); contact vertices, cable stations and effectors move
with their rows of Φ, multiplied with the weights once.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from tauten.model import (
    Assembled,
    ContactRows,
    Integration,
    RobotRows,
    Rows,
    State,
    System,
    TetRobot,
)
from tauten.model.contact import ContactSet
from tauten.model.numerics import Array, Ints
from tauten.reduction.dense_step import DenseAssembled, implicit_system, scheme_of, shares_of
from tauten.reduction.reduced_robot import ElementSample, ReducedRobot
from tauten.reduction.state.tetra.actuators import ReducedActuators, reduced_actuators
from tauten.reduction.state.tetra.arrays import Body, Response, Work, make_work
from tauten.reduction.state.tetra.body import (
    ReducedPoints,
    contact_surface,
    sampled_body,
)
from tauten.reduction.state.tetra.ecsw import sample_elements
from tauten.reduction.state.tetra.elements import assemble_response
from tauten.reduction.state.tetra.kernels import combine, contact_jacobian
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
class ReducedTetRobot(ReducedRobot):
    """A reduced robot made of tetrahedra.

    Attributes, beside those of every reduced robot:
        body: sampled elements.
        actuator_set: rows and curvature of its actuators.
        mass: (r, r) Φᵀ M Φ [kg].
        load: (r,) Φᵀ of gravity and outer forces [N].
        effector_points: points that the effectors are functions of.
        effector_places: (3 p, r) displacement of the effectors, where outer forces act on them.
        surface: vertices of candidates and target triangles.
        contacts: candidates and triangles on the vertices of `surface`.
        candidate_motion: (n_c, 3, r) derivative of the candidates with respect to α.
        work: workspace of the kernels.
    """

    full: TetRobot
    body: Body
    actuator_set: ReducedActuators
    mass: Array
    load: Array
    effector_points: ReducedPoints
    effector_places: Array
    surface: ReducedPoints
    contacts: ContactSet
    candidate_motion: Array
    work: Work

    @property
    def n_elements(self) -> int:
        """Elements in the sample."""
        return self.body.elements

    def fork(self) -> ReducedTetRobot:
        """The same robot with a workspace of its own."""
        return dataclasses.replace(self, work=make_work(self.body, self.actuator_set.tendons))

    def loaded(self, gravity: Array, effector_force: Array) -> ReducedTetRobot:
        """The robot under another gravity (3,) [m/s²] and forces on its effectors (3 p,) [N]."""
        full = self.full.loaded(gravity, effector_force)
        return dataclasses.replace(self, full=full, load=self.Phi.T @ full.load)

    def lifted(self, state: State) -> State:
        """The state of the full robot: q₀ + Φ α, Φ v."""
        Phi = self.Phi
        return State(self.full.rest().q + Phi @ state.q, Phi @ state.v)

    def projected(self, state: State) -> State:
        """The nearest state to one of the full robot, in the mass."""
        weight = 3.0 * self.full.mass / self.full.mass.sum()  # (n,)
        Phi = self.Phi
        return State(Phi.T @ (weight * (state.q - self.full.rest().q)), Phi.T @ (weight * state.v))

    def effector(self, state: State) -> Array:
        """Positions of the effectors: (p, 3) [m]."""
        return self.full.effectors.kinds.positions(self.effector_points.at(state.q))

    def effector_values(self, state: State) -> Array:
        """Goal values of the effectors: (n_v,)."""
        return self.full.effectors.kinds.values(self.effector_points.at(state.q))

    def candidates(self, state: State) -> Array:
        """Positions of the contact candidates: (n_c, 3) [m]."""
        return self.contacts.positions(self.surface.at(state.q))

    def displacement(self, state: State, dq: Array) -> float:
        """Largest displacement of an effector or contact vertex in a change dq (r,) [m]."""
        parts = (self.effector_places @ dq, self.surface.map @ dq)
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
        efforts = actuators.efforts(np.zeros(self.n_a) if effort is None else effort)
        actuators.set_curvature(alpha, efforts, response.curvature)
        preload = actuators.preload(alpha)
        load = self.load if preload is None else self.load + preload
        damped = not scheme.static and scheme.rayleigh_stiffness > 0.0
        assemble_response(alpha, state.v, load, damped, self.body, response)
        return SampledAssembled(
            state, effort, self.mass, response.force.copy(), np.zeros(self.n),
            response.resisting.copy(), actuators.tensions(efforts), response, damped,
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
        tendons = self.actuator_set.tendons
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

    def rows(self, state: State, contacts: bool = True) -> RobotRows:
        """Rows of effectors, actuators and, where `contacts` is true, contacts at this state."""
        return RobotRows(
            effectors=self.full.effectors.kinds.rows(self.effector_points.placed(state.q)),
            actuators=self.actuator_set.rows(state.q),
            contacts=self._contact_rows(state.q) if contacts else self._no_contact_rows(),
        )

    def _contact_rows(self, alpha: Array) -> ContactRows:
        found = self.contacts.detect(self.surface.at(alpha))
        H = contact_jacobian(
            found.normal, found.slots, found.vertices, found.coefficients,
            self.candidate_motion, self.surface.map,
        )  # fmt: skip
        return ContactRows(Rows(H, found.gap), found)

    def _no_contact_rows(self) -> ContactRows:
        return ContactRows.out_of_range(np.zeros((0, self.n)), self.n_c)


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
        body = sampled_body(robot, Phi, elements, weights)
        actuators = reduced_actuators(robot, Phi)
        surface, contacts = contact_surface(robot, Phi)
        by_mode = [contacts.positions(mode.reshape(-1, 3)) for mode in surface.map.T]
        effectors = robot.effectors.placed(robot.mesh.nodes)
        points, places = effectors.y.ravel(), robot.effectors.kinds.places(effectors)
        return ReducedTetRobot(
            full=robot,
            Phi=Phi,
            integration=robot.integration,
            body=body,
            actuator_set=actuators,
            mass=Phi.T @ (robot.mass[:, None] * Phi),
            load=Phi.T @ robot.load,
            effector_points=ReducedPoints(points, np.asarray(robot.effectors.C @ Phi)),
            effector_places=np.asarray(places.H @ Phi),
            surface=surface,
            contacts=contacts,
            candidate_motion=np.stack(by_mode, axis=2),
            work=make_work(body, actuators.tendons),
        )
