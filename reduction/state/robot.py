"""A robot in reduced coordinates: the interface of the full one, no array of a step as long as its mesh.

q = q₀ + Φ α (14). State.q is α, State.v its rate. Forces and tangent are sums over a sample of elements,
directly in α (`tauten.reduction.state.kernels`); contact vertices, cable stations and effectors move
with their rows of Φ, multiplied with the weights once.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from tauten.model import (
    Actuators,
    ContactRows,
    EffectorLayout,
    Integration,
    Limits,
    PairSlots,
    Robot,
    RobotRows,
    Rows,
    State,
    System,
)
from tauten.model.contact import ContactSet
from tauten.model.numerics import Array, DenseFactors, FactorisationError, Ints
from tauten.model.tetra import TetRobot
from tauten.reduction.state.actuators import ReducedActuators, reduced_actuators
from tauten.reduction.state.arrays import Body, Dynamics, Work, make_work
from tauten.reduction.state.basis import StateBasis, reducible_robot
from tauten.reduction.state.body import (
    ReducedPoints,
    contact_surface,
    sampled_body,
)
from tauten.reduction.state.kernels import (
    assemble_sample,
    contact_jacobian,
    linearise,
)


@dataclass(frozen=True, slots=True, eq=False)
class ReducedRobot:
    """A `Robot` of r unknowns, made by `reduced_robot`.

    Attributes:
        full: the robot it replaces.
        states: state basis and sample of elements.
        integration: time step and scheme.
        body: sampled elements.
        actuator_set: rows and curvature of its actuators.
        mass: (r, r) Φᵀ M Φ [kg].
        load: (r,) Φᵀ of gravity and outer forces [N].
        effector_points: points that the effectors are functions of.
        effector_places: (3 p, r) displacement of the effectors, where outer forces act on them.
        surface: vertices of candidates and target triangles.
        contacts: candidates and triangles on the vertices of `surface`.
        work: workspace of the kernels.
    """

    full: TetRobot
    states: StateBasis
    integration: Integration
    body: Body
    actuator_set: ReducedActuators
    mass: Array
    load: Array
    effector_points: ReducedPoints
    effector_places: Array
    surface: ReducedPoints
    contacts: ContactSet
    work: Work

    @property
    def name(self) -> str:
        """Name in keys and messages."""
        return self.full.name

    @property
    def frame(self) -> str:
        """Frame id of its positions on the wire."""
        return self.full.frame

    @property
    def digest(self) -> str:
        """Digest of the full robot: contact bases fit both."""
        return self.full.digest

    @property
    def gravity(self) -> Array:
        """Gravity that acts on it: (3,) [m/s²]."""
        return self.full.gravity

    @property
    def tolerance(self) -> float:
        """Depth of penetration from which a unit column is added for a contact candidate [m]."""
        return self.full.tolerance

    @property
    def h(self) -> float:
        """Time step [s]."""
        return self.integration.h

    @property
    def n(self) -> int:
        """Unknowns, r."""
        return len(self.load)

    @property
    def n_a(self) -> int:
        """Actuators; couplings count as one."""
        return len(self.full.actuators)

    @property
    def n_e(self) -> int:
        """Effector rows."""
        return self.effector_layout.n_rows

    @property
    def effector_layout(self) -> EffectorLayout:
        """Kinds of the effectors, their rows, goal values and weights."""
        return self.full.effector_layout

    @property
    def n_c(self) -> int:
        """Contact candidates, slots of λ_c."""
        return self.contacts.n_slots

    @property
    def n_nodes(self) -> int:
        """Nodes of the full robot."""
        return self.full.n_nodes

    @property
    def n_elements(self) -> int:
        """Elements in the sample."""
        return len(self.body.volume)

    @property
    def size(self) -> float:
        """Diagonal of the bounding box at rest [m]."""
        return self.full.size

    @property
    def linear_solver(self) -> str:
        """Name of the solver of its linear systems."""
        return DenseFactors.name

    @property
    def limits(self) -> Limits:
        """Limits of the actuators."""
        return self.full.limits

    @property
    def actuators(self) -> Actuators:
        """Names, kinds and laws of the actuators, in the order of λ_a."""
        return self.full.actuators

    @property
    def effector_names(self) -> tuple[str, ...]:
        """Names of the effectors, in row order."""
        return self.full.effector_names

    @property
    def triangles(self) -> Ints:
        """Surface of the full robot, indices into `points`: (t, 3)."""
        return self.full.triangles

    @property
    def pairs(self) -> tuple[PairSlots, ...]:
        """Contact pairs in the order of their slots."""
        return self.full.pairs

    def fork(self) -> ReducedRobot:
        """The same robot with a workspace of its own."""
        return dataclasses.replace(self, work=make_work(self.body, self.actuator_set.tendons))

    def loaded(self, gravity: Array, effector_force: Array) -> ReducedRobot:
        """The robot under another gravity (3,) [m/s²] and forces on its effectors (3 p,) [N]."""
        full = self.full.loaded(gravity, effector_force)
        return dataclasses.replace(self, full=full, load=self.states.Phi.T @ full.load)

    def rest(self) -> State:
        """The stress-free state at standstill."""
        return State(np.zeros(self.n), np.zeros(self.n))

    def lifted(self, state: State) -> State:
        """The state of the full robot: q₀ + Φ α, Φ v."""
        Phi = self.states.Phi
        return State(self.full.rest().q + Phi @ state.q, Phi @ state.v)

    def projected(self, state: State) -> State:
        """The nearest state to one of the full robot, in the mass."""
        weight = 3.0 * self.full.mass / self.full.mass.sum()  # (n,)
        Phi = self.states.Phi
        return State(Phi.T @ (weight * (state.q - self.full.rest().q)), Phi.T @ (weight * state.v))

    def effector(self, state: State) -> Array:
        """Positions of the effectors: (p, 3) [m]."""
        return self.full.effectors.kinds.positions(self.effector_points.at(state.q))

    def effector_values(self, state: State) -> Array:
        """Goal values of the effectors: (n_v,)."""
        return self.full.effectors.kinds.values(self.effector_points.at(state.q))

    def points(self, state: State) -> Array:
        """Positions of all nodes, which `triangles` refers to: (n_nodes, 3) [m]; as long as the mesh."""
        return self.full.points(self.lifted(state))

    def candidates(self, state: State) -> Array:
        """Positions of the contact candidates: (n_c, 3) [m]."""
        return self.contacts.positions(self.surface.at(state.q))

    def displacement(self, dq: Array) -> float:
        """Largest displacement of an effector or contact vertex in a change dq (r,) [m]."""
        parts = (self.effector_places @ dq, self.surface.map @ dq)
        return max(float(np.abs(part).max(initial=0.0)) for part in parts)

    def forces(
        self, state: State, tension: Array | None = None, exact: bool = False
    ) -> tuple[Array, Array]:
        """Forces without actuators and contacts (r,) [N], and the tangent K (r, r).

        Args:
            state: where to evaluate.
            tension: (n_a,) efforts of the actuators, whose curvature enters the tangent.
            exact: the exact derivative, which is not always positive definite.
        """
        taut, load = self._loads(state.q, tension)
        tendons = self.actuator_set.tendons
        assemble_sample(state.q, taut, load, exact, self.body, tendons, self.work)
        return self.work.force.copy(), self.work.K.copy()

    def linearise(
        self, state: State, tension: Array | None = None, integration: Integration | None = None
    ) -> System:
        """The system of one step from this state: A, b, v_free (7)-(10).

        Args:
            state: where the step starts.
            tension: (n_a,) last efforts of the actuators, for the curvature they add to A.
            integration: replaces the robot's own scheme.

        Raises:
            FactorisationError: A is not positive definite (a state that has blown up).
        """
        scheme, work = integration or self.integration, self.work
        taut, load = self._loads(state.q, tension)
        residual = linearise(
            state.q, state.v, taut, load,
            Dynamics(
                self.mass, scheme.h, scheme.static, scheme.rayleigh_mass, scheme.rayleigh_stiffness
            ),
            self.body, self.actuator_set.tendons, work,
        )  # fmt: skip
        if not np.isfinite(residual):
            raise FactorisationError("the reduced model's matrix is not positive definite")
        v = np.zeros(self.n) if scheme.static else state.v
        return System(scheme.h, v, work.v_free.copy(), residual, DenseFactors(work.L))

    def rows(self, state: State, contacts: bool = True) -> RobotRows:
        """Rows of effectors, actuators and, where `contacts` is true, contacts at this state."""
        return RobotRows(
            effectors=self.full.effectors.kinds.rows(
                self.effector_points.at(state.q), self.effector_points.map
            ),
            actuators=self.actuator_set.rows(state.q),
            contacts=self._contact_rows(state.q) if contacts else self._no_contact_rows(),
        )

    def advance(self, state: State, system: System, dv: Array) -> State:
        """The state one step later: v + dv and α + h (v + dv).

        Args:
            state: before the step.
            system: of this step; its v is zero when quasi-static.
            dv: (r,) change of the velocity [m/s].
        """
        v = system.v + dv
        return State(state.q + system.h * v, v)

    def _loads(self, alpha: Array, tension: Array | None) -> tuple[Array, Array]:
        """Tensions of the cables and the load (r,) [N]; sets the curvature of the chambers."""
        actuators = self.actuator_set
        efforts = actuators.efforts(np.zeros(self.n_a) if tension is None else tension)
        actuators.set_curvature(alpha, efforts, self.work.curvature)
        preload = actuators.preload(alpha)
        load = self.load if preload is None else self.load + preload
        return actuators.tensions(efforts), load

    def _contact_rows(self, alpha: Array) -> ContactRows:
        found = self.contacts.detect(self.surface.at(alpha))
        H = contact_jacobian(found.normal, found.vertices, found.coefficients, self.surface.map)
        return ContactRows(Rows(H, found.gap), found.slots, found.pair, self.n_c)

    def _no_contact_rows(self) -> ContactRows:
        return ContactRows.out_of_range(np.zeros((0, self.n)), self.n_c)


def reduced_robot(robot: Robot, states: StateBasis) -> ReducedRobot:
    """The robot in the coordinates of a state basis.

    Raises:
        StateBasisError: the basis was made for another robot, or this one is not made of tetrahedra.
    """
    states.check_robot(robot)
    robot = reducible_robot(robot)
    Phi = states.Phi
    body = sampled_body(robot, Phi, states.elements, states.weights)
    actuators = reduced_actuators(robot, Phi)
    surface, contacts = contact_surface(robot, Phi)
    return ReducedRobot(
        full=robot,
        states=states,
        integration=robot.integration,
        body=body,
        actuator_set=actuators,
        mass=Phi.T @ (robot.mass[:, None] * Phi),
        load=Phi.T @ robot.load,
        effector_points=ReducedPoints(
            robot.effectors.points(robot.mesh.nodes).ravel(), np.asarray(robot.effectors.C @ Phi)
        ),
        effector_places=np.asarray(robot.effectors.kinds.force_map(robot.effectors.C) @ Phi),
        surface=surface,
        contacts=contacts,
        work=make_work(body, actuators.tendons),
    )
