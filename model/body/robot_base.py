"""What every robot has, whatever its coordinates: names, rows over its points, energies, iterated steps."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
import scipy.sparse as sp

from tauten.model.actuators import ActuatorSet
from tauten.model.contact import ContactSet, contact_rows
from tauten.model.effectors import Effectors
from tauten.model.interface import Actuators, EffectorLayout, Limits
from tauten.model.layout import Layout, row_layout
from tauten.model.numerics import Array, Factorisation, FactorisationError, Ints
from tauten.model.points import Motion
from tauten.model.robot import Assembled, RobotNames, RobotRows, State, StepStart, Turning
from tauten.model.rows import ContactRows, PairSlots
from tauten.model.system import Integration, System, make_iterate

P = TypeVar("P")


@dataclass(frozen=True, slots=True, eq=False)
class RobotBase(ABC, Generic[P]):
    """Names, sizes and rows of a `Robot` whose points are of type P (`tauten.model.points.Motion`).

    Attributes:
        names: of the robot and its effectors.
        digest: of its description, see `tauten.model.schema.robot_digest`.
        gravity: (3,) [m/s²].
        tolerance: depth of penetration from which a unit column is added for a contact candidate [m].
        integration: time step and scheme.
        actuators: names, kinds and laws of its actuators.
        actuator_set: their rows.
        limits: limits of their efforts, positions and rates.
        effectors: what is to reach targets.
        contacts: candidates and the surfaces they may touch, and
        vertices: the points of these surfaces.
    """

    names: RobotNames
    digest: str
    gravity: Array
    tolerance: float
    integration: Integration
    actuators: Actuators
    actuator_set: ActuatorSet[P]
    limits: Limits
    effectors: Effectors[P]
    contacts: ContactSet
    vertices: P

    @property
    def name(self) -> str:
        """Name in keys and messages."""
        return self.names.robot

    @property
    def frame(self) -> str:
        """Frame id of its positions on the wire."""
        return self.names.frame

    @property
    def effector_names(self) -> tuple[str, ...]:
        """Names of the effectors, in row order."""
        return self.names.effectors

    @property
    def h(self) -> float:
        """Time step [s]."""
        return self.integration.h

    @property
    @abstractmethod
    def n(self) -> int:
        """Free degrees of freedom, the length of v."""

    @property
    def n_a(self) -> int:
        """Actuators; couplings count as one."""
        return len(self.actuators)

    @property
    def layout(self) -> Layout:
        """Where the rows of effectors, actuators and contacts are in a step."""
        return row_layout(self.effector_layout.n_rows, self.n_a)

    @property
    def effector_layout(self) -> EffectorLayout:
        """Kinds of the effectors, their rows, goal values and weights."""
        return self.effectors.kinds.layout

    @property
    def n_c(self) -> int:
        """Contact candidates, slots of λ_c."""
        return self.contacts.n_slots

    @property
    def pairs(self) -> tuple[PairSlots, ...]:
        """Contact pairs in the order of their slots."""
        return self.contacts.pair_slots

    @property
    @abstractmethod
    def triangles(self) -> Ints:
        """Surface as triples of `points`: (t, 3)."""

    @abstractmethod
    def motion(self, state: State) -> Motion[P]:
        """Where the points of the body are at a state, and how they move with the unknowns."""

    @abstractmethod
    def forces(
        self, state: State, effort: Array | None = None, exact: bool = False
    ) -> tuple[Array, Array]:
        """Forces without actuators and contacts (n,) [N], and K = −∂force/∂q as the robot stores it.

        Args:
            state: where to evaluate.
            effort: (n_a,) efforts of the actuators, whose curvature enters the tangent; None: none does.
            exact: exact derivative rather than the positive semidefinite tangent.
        """

    @abstractmethod
    def assemble(
        self, state: State, effort: Array | None = None, integration: Integration | None = None
    ) -> Assembled:
        """Forces and tangents at a state, valid until this robot assembles others.

        Args:
            state: where steps start.
            effort: (n_a,) last efforts of the actuators, for the curvature they add to A.
            integration: another scheme than the robot's. The steps may have any length, but its damping.
        """

    @abstractmethod
    def system(self, assembled: Assembled, integration: Integration) -> System:
        """The system of one step, `linearise` where forces and tangents are known.

        Args:
            assembled: by this robot or a fork.
            integration: scheme and length of the step.

        Raises:
            FactorisationError: A is not positive definite (a state that has blown up).
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
        scheme = integration or self.integration
        return self.system(self.assemble(state, effort, scheme), scheme)

    def effector(self, state: State) -> Array:
        """Positions of the effectors: (p, 3) [m]."""
        return self.effectors.positions(self.motion(state))

    def effector_values(self, state: State) -> Array:
        """Goal values of the effectors: (n_v,)."""
        return self.effectors.values(self.motion(state))

    def candidates(self, state: State) -> Array:
        """Positions of the contact candidates: (n_c, 3) [m]."""
        return self.contacts.positions(self.motion(state).placed(self.vertices).y)

    @property
    def segment_owners(self) -> Ints:
        """The actuator of every segment that `actuator_segments` gives: (s,)."""
        return self.actuator_set.segment_owners

    @property
    def chamber_owners(self) -> Ints:
        """The actuator whose chamber each of `triangles` encloses, −1 where none: (t,)."""
        return self.actuator_set.chamber_owners(self.triangles)

    def actuator_segments(self, state: State) -> Array:
        """Segments by which actuators are drawn: (s, 2, 3) [m], see `Robot`."""
        return self.actuator_set.segments(self.motion(state))

    def rows(self, state: State, contacts: bool = True) -> RobotRows:
        """Rows of effectors, actuators and, with `contacts`, contacts at this state."""
        motion = self.motion(state)
        found = self.contact_rows(motion) if contacts else self.no_contact_rows(motion)
        return RobotRows(self.effectors.rows(motion), self.actuator_set.rows(motion), found)

    def contact_rows(self, motion: Motion[P]) -> ContactRows:
        """Gaps and H_c of the candidates in range."""
        placed = motion.placed(self.vertices)
        return contact_rows(self.contacts.detect(placed.y), placed)

    def no_contact_rows(self, motion: Motion[P]) -> ContactRows:
        """Contact rows with no candidate in range."""
        return ContactRows.out_of_range(motion.units(np.zeros(0, dtype=np.int64)), self.n_c)

    @abstractmethod
    def masses(self, state: State) -> Array:
        """The mass matrix at a state as the robot stores it, or lumped masses (n,) [kg], [kg m²]."""

    @abstractmethod
    def matrix(self, values: Array) -> sp.csc_array | Array:
        """A matrix (n, n), from values as the robot stores them or from lumped masses (n,)."""

    @abstractmethod
    def add_mass(self, values: Array, mass: Array) -> None:
        """Add what `masses` gives to a matrix as the robot stores it."""

    @abstractmethod
    def damping_at(self, state: State, scheme: Integration) -> tuple[Array | None, Array]:
        """Forces (n,) of viscous materials' memory [N] or None, and C without a M as the robot stores it.

        Args:
            state: where a step is linearised.
            scheme: its length and damping.
        """

    @abstractmethod
    def factors(self) -> Factorisation:
        """A workspace for factors of matrices as the robot stores them."""

    def inertia_at(self, state: State) -> Array:
        """Centrifugal and gyroscopic forces (n,) at a state, none where the mass is constant [N]."""
        return np.zeros(self.n)

    @abstractmethod
    def potential(self, state: State) -> float:
        """Elastic energy minus the work of gravity and outer forces since rest [J]."""

    def turning_steps(self) -> Turning | None:
        """What replaces long straight steps by such that turn elements; None: nothing does."""
        return None

    def inverted(self, state: State) -> int:
        """Number of elements that are turned inside out."""
        return 0

    def stored(self, state: State) -> float:
        """Energy stored in the memory of viscous materials [J]."""
        return 0.0

    def kinetic_energy(self, state: State) -> float:
        """½ vᵀ M v [J]."""
        return 0.5 * float(state.v @ self.matrix(self.masses(state)) @ state.v)

    def energy(self, state: State) -> float:
        """Potential and kinetic energy, and that stored in viscous materials [J]."""
        return self.potential(state) + self.kinetic_energy(state) + self.stored(state)

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
        """Second derivative of ½ vᵀ C v by v h at the end of a step, where it may be approximated.

        Args:
            start: of the step, with C.
            K: tangent at the end.
        """
        return start.damping

    def step_start(self, state: State) -> StepStart:
        """The start of a step that is iterated, with mass, damping and constant forces there.

        Args:
            state: where the step starts.
        """
        scheme, mass = self.integration, self.masses(state)
        remembered, damping = self.damping_at(state, scheme)
        self.add_mass(damping, scheme.rayleigh_mass * mass)
        force = self.inertia_at(state)
        return StepStart(
            state, scheme, mass, damping, force if remembered is None else force + remembered
        )

    def step_energy(self, start: StepStart, v: Array) -> float:
        """Φ − Π of (C1): ½ (v − v₀)ᵀ M (v − v₀) + ½ h vᵀ C v − h vᵀ f of a velocity (n,) [J]."""
        change = v - start.state.v
        kinetic = 0.5 * float(change @ self.matrix(start.mass) @ change)
        viscous = 0.5 * (self.matrix(start.damping) @ v) - start.force
        return kinetic + self.h * float(v @ viscous)

    def linearise_iterate(self, state: State, start: StepStart, effort: Array) -> System:
        """The system of one iteration of a step that started elsewhere, without velocity of its own.

        Its solution dv moves the iterate by h dv.

        Args:
            state: the iterate.
            start: of the step.
            effort: (n_a,) tensions of the last iteration, for the curvature they add to A [N].

        Raises:
            FactorisationError: A is not positive definite.
        """
        v = self.velocity(start.state, state)
        accelerated = self.matrix(start.mass) @ (v - start.state.v) / self.h
        resisting = accelerated + self.matrix(start.damping) @ v - start.force
        inertia = self.at_end(start.state, state, resisting)
        for exact in (True, False):
            force, K = self.forces(state, effort, exact)
            A = self.h * self.h * K + self.h * self.damping_at_end(start, K)
            self.add_mass(A, start.mass)
            try:
                return make_iterate(self.factors(), self.h, A, force - inertia, exact)
            except FactorisationError:
                if not exact:
                    raise
        raise AssertionError("unreachable")
