"""A body: where its points are, its forces and its matrices, in coordinates of its own.

A `Robot` asks its body for the mechanics of a step and knows nothing of its coordinates. There are bodies
whose nodes move freely, bodies whose nodes follow frames, bodies of beams, and bodies of modes. Where steps
of several lengths start from one state, `assemble` gives forces and tangents there, and `system` the system
of each step.
"""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, Self

import numpy as np
import scipy.sparse as sp
from typing_extensions import TypeVar

from tauten.model.actuators import ActuatorRows
from tauten.model.effectors import Effectors
from tauten.model.numerics import Array, Factorisation, FactorisationError, Ints
from tauten.model.points import Motion
from tauten.model.state import Assembled, Augmentation, State, StepStart
from tauten.model.system import Integration, System, make_iterate

P = TypeVar("P", default=Any)

# 1/s; with them a mass counts as stiffness where nothing else holds it
RATES = (1.0, 10.0, 100.0, 1e3, 1e4)

# The displacement (n,) instead of a straight one (n,) from a state [m].
Turning = Callable[[State, Array], Array]


@dataclass(frozen=True, slots=True, eq=False)
class Body(ABC, Generic[P]):
    """A body whose points are of type P (`tauten.model.points.Motion`); immutable except for its workspace.

    Attributes:
        gravity: (3,) [m/s²].
        integration: time step and scheme.
        actuator_set: rows of the actuators that act on it.
    """

    gravity: Array
    integration: Integration
    actuator_set: ActuatorRows

    @property
    def h(self) -> float:
        """Time step [s]."""
        return self.integration.h

    @property
    @abstractmethod
    def n(self) -> int:
        """Free degrees of freedom, the length of v."""

    @property
    @abstractmethod
    def n_nodes(self) -> int:
        """Nodes, fixed ones included."""

    @property
    @abstractmethod
    def n_elements(self) -> int:
        """Finite elements."""

    @property
    @abstractmethod
    def moving_mass(self) -> float:
        """Mass of all nodes that are not fixed [kg]."""

    @property
    @abstractmethod
    def size(self) -> float:
        """Largest distance between two nodes at rest [m]."""

    @property
    def part_size(self) -> float:
        """Size of the largest part [m]; of the body itself where it has no parts."""
        return self.size

    @property
    @abstractmethod
    def linear_solver(self) -> str:
        """Name of what solves its linear systems."""

    @property
    @abstractmethod
    def stored_shape(self) -> tuple[int, ...]:
        """Shape of the values of a matrix as the body stores it."""

    @property
    @abstractmethod
    def triangles(self) -> Ints:
        """Surface as triples of `points`: (t, 3)."""

    @abstractmethod
    def surface_points(self, vertices: Ints) -> P:
        """Points of the body at some vertices (v,) of its surfaces, by their numbers in the full robot."""

    @abstractmethod
    def points(self, state: State) -> Array:
        """Positions of what `triangles` joins: (P, 3) [m]."""

    @abstractmethod
    def fork(self) -> Self:
        """The same body with a separate workspace."""

    def with_integration(self, integration: Integration) -> Self:
        """The same body with another time step or scheme."""
        return dataclasses.replace(self, integration=integration)

    @abstractmethod
    def loaded(self, gravity: Array, effector_force: Array, effectors: Effectors[P]) -> Self:
        """The body under other loads.

        Args:
            gravity: (3,) [m/s²].
            effector_force: (3 p,) forces on effectors [N].
            effectors: the effectors, over its points.
        """

    @abstractmethod
    def rest(self) -> State:
        """The stress-free state at standstill."""

    @abstractmethod
    def motion(self, state: State) -> Motion[P]:
        """Where the points of the body are at a state, and how they move with the unknowns."""

    @abstractmethod
    def displacement(self, state: State, dq: Array) -> float:
        """Largest displacement of a node in a change dq (n,) of the configuration at a state [m]."""

    @abstractmethod
    def advance(self, state: State, v: Array, h: float, straight: bool = False) -> State:
        """The state one step later, with the velocity v and moved by h v, see `Robot`."""

    @abstractmethod
    def forces(
        self, state: State, effort: Array | None = None, exact: bool = False
    ) -> tuple[Array, Array]:
        """Forces without actuators and contacts (n,) [N], and K = −∂force/∂q, see `Robot`."""

    @abstractmethod
    def assemble(
        self, state: State, effort: Array | None = None, integration: Integration | None = None
    ) -> Assembled:
        """Forces and tangents at a state, valid until this body assembles others.

        Args:
            state: where steps start.
            effort: (n_a,) last efforts of the actuators, for the curvature they add to A.
            integration: another scheme than the body's. The steps may have any length, but its damping.
        """

    def linearise(
        self, state: State, effort: Array | None = None, integration: Integration | None = None
    ) -> System:
        """The system of one step from a state, see `Robot`; it may take less than several of them."""
        scheme = integration or self.integration
        return self.system(self.assemble(state, effort, scheme), scheme)

    @abstractmethod
    def system(
        self, assembled: Assembled, integration: Integration, added: Augmentation = None
    ) -> System:
        """The system of one step, `Robot.linearise` where forces and tangents are known.

        Args:
            assembled: by this body or one that it is a fork of or that is a fork of it.
            integration: scheme and length of the step.
            added: to the tangent, see `Assembled.augmentation`.

        Raises:
            FactorisationError: A is not positive definite (a state that has blown up).
        """

    @abstractmethod
    def masses(self, state: State) -> Array:
        """The mass matrix at a state as the body stores it, or lumped masses (n,) [kg], [kg m²]."""

    @abstractmethod
    def matrix(self, values: Array) -> sp.csc_array | Array:
        """A matrix (n, n), from values as the body stores them or from lumped masses (n,)."""

    @abstractmethod
    def add_mass(self, values: Array, mass: Array) -> None:
        """Add what `masses` gives to a matrix as the body stores it."""

    @abstractmethod
    def damping_at(self, state: State, scheme: Integration) -> tuple[Array | None, Array]:
        """Forces (n,) of viscous materials' memory [N] or None, and C without a M as the body stores it."""

    @abstractmethod
    def factors(self) -> Factorisation:
        """A workspace for factors of matrices as the body stores them."""

    @abstractmethod
    def potential(self, state: State) -> float:
        """Elastic energy minus the work of gravity and outer forces since rest [J]."""

    @property
    def part_robots(self) -> tuple[Any, ...]:
        """The robots of its parts, where it has several; else none."""
        return ()

    @property
    def floats(self) -> bool:
        """Whether nothing holds a part of it, which moves by its inertia in quasi-static steps too."""
        return False

    def floating_mass(self, state: State) -> Array | None:
        """Mass, see `masses`, of what moves by its inertia in quasi-static steps too; None: nothing does."""
        return None

    def floating_velocity(self, state: State) -> Array:
        """Velocity (n,) of what moves by its inertia in quasi-static steps too, zero of all else."""
        return np.zeros_like(state.v)

    def inertia_at(self, state: State) -> Array | None:
        """Centrifugal and gyroscopic forces (n,) at a state [N]; None where the mass is constant."""
        return None

    @property
    def motor_coordinates(self) -> Ints:
        """Degrees of freedom that a motor holds: those of drives and drums."""
        return self.actuator_set.motor_coordinates

    @property
    @abstractmethod
    def chamber_owners(self) -> Ints:
        """The actuator whose chamber each of `triangles` encloses, −1 where none: (t,)."""

    @property
    def of_objects(self) -> Ints:
        """Numbers (m,) of the `triangles` of parts without an actuator, beside others that have some."""
        return np.zeros(0, np.intp)

    @property
    def idle_parts(self) -> tuple[str, ...]:
        """Names of the parts that have neither actuators nor effectors."""
        return ()

    @property
    def part_names(self) -> tuple[str, ...]:
        """Names of the parts; none where the robot has no parts."""
        return ()

    @property
    def components(self) -> Ints:
        """Number of the set of each unknown (n,): sets act on each other through rows only."""
        return np.zeros(self.n, np.int64)

    def unknowns_of(self, part: str) -> slice:
        """The unknowns of a part; all of them where the robot has no parts."""
        return slice(0, self.n)

    def turning_steps(self) -> Turning | None:
        """What replaces long straight steps by such that turn elements; None: nothing does. Expensive."""
        return None

    def inverted(self, state: State) -> int:
        """Number of elements that are turned inside out."""
        return 0

    def remembering(self, before: State, after: State, h: float) -> State:
        """The state at the end of a step, with the memory of viscous materials there.

        Args:
            before: the state where it starts.
            after: that where it ends, without memory.
            h: its length [s]; 0: what is remembered is carried there, and does not relax.
        """
        return after

    def stored(self, state: State) -> float:
        """Energy stored in the memory of viscous materials [J]."""
        return 0.0

    def kinetic_energy(self, state: State) -> float:
        """½ vᵀ M v [J]."""
        return 0.5 * float(state.v @ self.matrix(self.masses(state)) @ state.v)

    def velocity(self, start: State, end: State) -> Array:
        """The velocity (n,) that moves one state to another within a step [m/s], [rad/s]."""
        v: Array = (end.q - start.q) / self.h
        return v

    def at_end(self, start: State, end: State, force: Array) -> Array:
        """Forces (n,) at the end of a step that do the work of given ones at its start [N].

        Args:
            start: of the step.
            end: of the step.
            force: (n,) forces that do work on displacements v h [N].
        """
        return force

    def damping_at_end(self, start: StepStart, K: Array) -> Array:
        """Second derivative of ½ vᵀ C v by v h at the end of a step, where it may be approximated."""
        return start.damping

    def step_start(self, state: State) -> StepStart:
        """The start of a step that is iterated, with mass, damping and constant forces there.

        In quasi-static steps these are those of what floats.
        """
        scheme, remembered = self.integration, None
        if scheme.static:
            damping, mass = np.zeros(self.stored_shape), self.floating_mass(state)
            if mass is None:
                return StepStart(state, scheme, damping, damping, np.zeros(self.n))
            state = dataclasses.replace(state, v=self.floating_velocity(state))
        else:
            mass = self.masses(state)
            remembered, damping = self.damping_at(state, scheme)
        self.add_mass(damping, scheme.rayleigh_mass * mass)
        constant = np.zeros(self.n)
        for force in (self.inertia_at(state), remembered):
            constant = constant if force is None else constant + force
        return StepStart(state, scheme, mass, damping, constant)

    def step_energy(self, start: StepStart, v: Array) -> float:
        """Φ − Π of (C1): ½ (v − v₀)ᵀ M (v − v₀) + ½ h vᵀ C v − h vᵀ f of a velocity (n,) [J]."""
        change = v - start.state.v
        kinetic = 0.5 * float(change @ self.matrix(start.mass) @ change)
        viscous = 0.5 * (self.matrix(start.damping) @ v) - start.force
        return kinetic + self.h * float(v @ viscous)

    def linearise_iterate(self, state: State, start: StepStart, effort: Array) -> System:
        """The system of one iteration of a step that started elsewhere, without velocity of its own.

        Its solution dv moves the iterate by h dv. What nothing holds in a quasi-static step, as a rigid body
        that may turn about its pin, is held by its mass, which changes no end of the iterations.

        Args:
            state: the iterate.
            start: of the step.
            effort: (n_a,) efforts of the last iteration, for the curvature they add to A [N].

        Raises:
            FactorisationError: A is not positive definite.
        """
        v = self.velocity(start.state, state)
        accelerated = self.matrix(start.mass) @ (v - start.state.v) / self.h
        resisting = accelerated + self.matrix(start.damping) @ v - start.force
        inertia = self.at_end(start.state, state, resisting)
        failed = FactorisationError("no tangent was tried")
        for exact, rate in ((True, 0.0), (False, 0.0), *((False, rate) for rate in RATES)):
            if rate == 0.0:
                force, K = self.forces(state, effort, exact)
            A = self.h * self.h * K + self.h * self.damping_at_end(start, K)
            self.add_mass(A, start.mass)
            if rate > 0.0:
                self.add_mass(A, (self.h * rate) ** 2 * self.masses(state))
            try:
                return make_iterate(self.factors(), self.h, A, force - inertia, exact)
            except FactorisationError as error:
                failed = error
        raise failed
