"""The robot: the interface that a step uses, for every kind of body.

`linearise` gives the system of one step, `rows` the rows of effectors, actuators and contacts,
`advance` the next state, `rest` the initial one. Where steps of several lengths start from one state,
`assemble` gives forces and tangents there, and `system` the system of each step. A robot is immutable except
for its workspace: code that steps a robot uses a `fork` of it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
import scipy.sparse as sp

from tauten.model.interface import Actuators, EffectorLayout, Limits
from tauten.model.layout import Layout
from tauten.model.numerics import Array, Ints
from tauten.model.rows import ContactRows, EffectorRows, PairSlots, Rows
from tauten.model.schema import RobotSettings
from tauten.model.system import Integration, System


@dataclass(frozen=True, slots=True)
class State:
    """Configuration and velocity of the free degrees of freedom.

    Attributes:
        q: configuration [m], of any length: beams keep rotations beside positions.
        v: (n,) velocity [m/s], [rad/s] where degrees of freedom are rotations.
        memory: stresses of viscous materials (`tauten.model.tetra.viscoelastic`); empty: they are relaxed.
    """

    q: Array
    v: Array
    memory: Array = field(default_factory=lambda: np.zeros(0))

    def copy(self) -> State:
        """The same state in arrays of its own."""
        return State(self.q.copy(), self.v.copy(), self.memory.copy())


@dataclass(frozen=True, slots=True)
class Assembled:
    """Forces and tangents at a state, of which `Robot.system` makes systems; each kind of robot adds its own.

    Attributes:
        state: where they were evaluated.
        effort: (n_a,) efforts of the actuators whose curvature is in the tangent; None: none is.
    """

    state: State
    effort: Array | None


@dataclass(frozen=True, slots=True)
class StepStart:
    """Where a time step that is iterated starts.

    Attributes:
        state: configuration and velocity there.
        integration: scheme and time step.
        mass: the mass matrix M there, as the robot stores it.
        damping: the matrix C of the viscous forces −C v in the step, as the robot stores it.
        force: (n,) other forces that are constant in the step: those of viscous materials' memory, and of
            inertia at constant velocities [N].
    """

    state: State
    integration: Integration
    mass: Array
    damping: Array
    force: Array


@dataclass(frozen=True, slots=True)
class RobotRows:
    """The rows that effectors, actuators and contacts contribute to a step.

    Attributes:
        effectors: positions x_e and other kinds, see `EffectorLayout`.
        actuators: positions δ_a.
        contacts: signed gaps of the candidates in range.
    """

    effectors: EffectorRows
    actuators: Rows
    contacts: ContactRows


@dataclass(frozen=True, slots=True)
class RobotNames:
    """Names in keys, messages and tables.

    Attributes:
        robot: of the robot.
        frame: frame id of its positions.
        effectors: in row order.
    """

    robot: str
    frame: str
    effectors: tuple[str, ...]


def names_of(config: RobotSettings) -> RobotNames:
    """The names in a robot file."""
    return RobotNames(
        robot=config.name,
        frame=config.frame,
        effectors=tuple(effector.name for effector in config.effectors),
    )


# The displacement (n,) instead of a straight one (n,) from a state [m].
Turning = Callable[[State, Array], Array]


class Robot(Protocol):
    """A soft robot. Robots can be pickled, their workspace without its factors."""

    @property
    def name(self) -> str:
        """Name in keys and messages."""

    @property
    def frame(self) -> str:
        """Frame id of its positions on the wire."""

    @property
    def digest(self) -> str:
        """What its contact forces depend on, from its files alone, see `tauten.model.schema.robot_digest`."""

    @property
    def gravity(self) -> Array:
        """Gravity that acts on it: (3,) [m/s²]."""

    @property
    def tolerance(self) -> float:
        """Depth of penetration from which a unit column is added for a contact candidate [m]."""

    @property
    def integration(self) -> Integration:
        """Time step and scheme."""

    @property
    def h(self) -> float:
        """Time step [s]."""

    @property
    def n(self) -> int:
        """Free degrees of freedom, the length of v."""

    @property
    def n_a(self) -> int:
        """Actuators; couplings count as one."""

    @property
    def layout(self) -> Layout:
        """Where the rows of effectors, actuators and contacts are in a step."""

    @property
    def effector_layout(self) -> EffectorLayout:
        """Kinds of the effectors, their rows, goal values and weights."""

    @property
    def n_c(self) -> int:
        """Contact candidates, slots of λ_c."""

    @property
    def n_nodes(self) -> int:
        """Nodes, fixed ones included."""

    @property
    def n_elements(self) -> int:
        """Finite elements."""

    @property
    def moving_mass(self) -> float:
        """Mass of all nodes that are not fixed [kg]."""

    @property
    def size(self) -> float:
        """Diagonal of the bounding box at rest [m]."""

    @property
    def linear_solver(self) -> str:
        """Name of what solves its linear systems."""

    @property
    def limits(self) -> Limits:
        """Limits of the actuators."""

    @property
    def actuators(self) -> Actuators:
        """Names, kinds and laws of the actuators, in the order of λ_a."""

    @property
    def effector_names(self) -> tuple[str, ...]:
        """Names of the effectors, in row order."""

    @property
    def triangles(self) -> Ints:
        """Its surface as triples of `points`, for drawing: (t, 3)."""

    @property
    def pairs(self) -> tuple[PairSlots, ...]:
        """Contact pairs in the order of their slots."""

    def fork(self) -> Robot:
        """The same robot with a separate workspace."""

    def loaded(self, gravity: Array, effector_force: Array) -> Robot:
        """The robot under another gravity (3,) [m/s²] and forces on its effectors (3 p,) [N]."""

    def rest(self) -> State:
        """The stress-free state at standstill."""

    def effector(self, state: State) -> Array:
        """Positions of the effectors: (p, 3) [m]; of a distance, length or volume, of its points' mean."""

    def effector_values(self, state: State) -> Array:
        """Goal values of the effectors: (n_v,), see `EffectorLayout`."""

    def points(self, state: State) -> Array:
        """Positions of what `triangles` joins: (P, 3) [m]."""

    def candidates(self, state: State) -> Array:
        """Positions of the contact candidates: (n_c, 3) [m]."""

    @property
    def segment_owners(self) -> Ints:
        """The actuator of every segment that `actuator_segments` gives: (s,)."""

    def actuator_segments(self, state: State) -> Array:
        """Segments by which actuators are drawn: (s, 2, 3) [m].

        Of cables both ends of every straight piece; of forces, drives and slides where they act, and the
        point one metre along their direction or axis.
        """

    @property
    def chamber_owners(self) -> Ints:
        """The actuator whose chamber each of `triangles` encloses, −1 where none: (t,)."""

    def displacement(self, state: State, dq: Array) -> float:
        """Largest displacement of a node in a change dq (n,) of the configuration at a state [m]."""

    def forces(
        self, state: State, effort: Array | None = None, exact: bool = False
    ) -> tuple[Array, Array]:
        """Forces without actuators and contacts (n,) [N], and the tangent K as the robot stores it.

        Args:
            state: where to evaluate.
            effort: (n_a,) efforts of the actuators, whose curvature enters the tangent.
            exact: the exact derivative, which is not always positive definite.
        """

    def linearise(
        self, state: State, effort: Array | None = None, integration: Integration | None = None
    ) -> System:
        """The system of one step from this state: A, b, v_free (7)-(10).

        Args:
            state: where the step starts.
            effort: (n_a,) last efforts of the actuators, for the curvature they add to A.
            integration: another scheme than the robot's.

        Raises:
            FactorisationError: A is not positive definite (a state that has blown up).
        """

    def assemble(
        self, state: State, effort: Array | None = None, integration: Integration | None = None
    ) -> Assembled:
        """Forces and tangents at a state, valid until this robot assembles others.

        Args:
            state: where steps start.
            effort: (n_a,) last efforts of the actuators, for the curvature they add to A.
            integration: another scheme than the robot's. The steps may have any length, but its damping.
        """

    def system(self, assembled: Assembled, integration: Integration) -> System:
        """The system of one step, `linearise` where forces and tangents are known.

        Args:
            assembled: by this robot or one that it is a fork of or that is a fork of it.
            integration: scheme and length of the step.

        Raises:
            FactorisationError: A is not positive definite (a state that has blown up).
        """

    def potential(self, state: State) -> float:
        """Elastic energy minus the work of gravity and outer forces, zero at rest [J]."""

    def kinetic_energy(self, state: State) -> float:
        """½ vᵀ M v [J]."""

    def energy(self, state: State) -> float:
        """Potential and kinetic energy, and that stored in viscous materials [J]."""

    def inverted(self, state: State) -> int:
        """Number of elements that are turned inside out."""

    def turning_steps(self) -> Turning | None:
        """What replaces long straight steps by such that turn elements; None: nothing does. Expensive."""

    def matrix(self, values: Array) -> sp.csc_array | Array:
        """A matrix (n, n) from values as the robot stores them."""

    def velocity(self, start: State, end: State) -> Array:
        """The velocity (n,) that moves one state to another within a step [m/s], [rad/s]."""

    def step_start(self, state: State) -> StepStart:
        """The start of a step that is iterated (`tauten.model.simulation.converged_step`)."""

    def step_energy(self, start: StepStart, v: Array) -> float:
        """What a velocity (n,) adds to the potential in a step that is iterated [J]."""

    def linearise_iterate(self, state: State, start: StepStart, effort: Array) -> System:
        """The system of one iteration of a step that started elsewhere.

        Args:
            state: the iterate.
            start: of the step.
            effort: (n_a,) efforts of the last iteration.

        Raises:
            FactorisationError: A is not positive definite.
        """

    def rows(self, state: State, contacts: bool = True) -> RobotRows:
        """Rows of effectors, actuators and, with `contacts`, contacts at this state."""

    def advance(self, state: State, system: System, dv: Array) -> State:
        """The state one step later: velocity v + dv, moved by h (v + dv).

        Args:
            state: before the step.
            system: of the step.
            dv: (n,) change of velocity [m/s].
        """
