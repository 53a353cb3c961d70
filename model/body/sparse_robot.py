"""The common part of robots with a sparse tangent."""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Self

import numpy as np
import scipy.sparse as sp

from tauten.model.contact import ContactSet
from tauten.model.limits import Limits
from tauten.model.numerics import Array, Factorisation, FactorisationError, Ints, make_factorisation
from tauten.model.points import AttachedPoints, BeamCables, CableSet, MaterialPoints
from tauten.model.robot import RobotNames, State, StepStart
from tauten.model.rows import ContactRows, PairSlots
from tauten.model.system import Integration, Pattern, System, make_iterate, make_system


@dataclass(frozen=True, slots=True)
class SparseRobot(ABC):
    """Names, sizes and the linear system of a `Robot` that has a pattern and a factorisation.

    Attributes:
        names: of the robot, its cables and its effectors.
        digest: SHA-256 of everything its contact forces depend on (body, material, cables, contacts).
        gravity: (3,) [m/s²].
        tolerance: depth of penetration from which a unit column is added for a contact candidate [m].
        integration: time step and scheme.
        pattern: sparsity of its matrices.
        mass: (n,) lumped mass of the free degrees of freedom [kg], [kg m²] where they are rotations.
        cables: its cables.
        cable_slot: places of the cables' curvature in the pattern.
        limits: limits of tension, pulled length and rate.
        effectors: points that are to reach targets.
        contacts: candidates and the surfaces they may touch.
        factorisation: workspace of the linear solver.
    """

    names: RobotNames
    digest: str
    gravity: Array
    tolerance: float
    integration: Integration
    pattern: Pattern
    mass: Array
    cables: CableSet | BeamCables
    cable_slot: tuple[Ints, Ints]
    limits: Limits
    effectors: MaterialPoints | AttachedPoints
    contacts: ContactSet
    factorisation: Factorisation

    @property
    def name(self) -> str:
        """Name in keys and messages."""
        return self.names.robot

    @property
    def frame(self) -> str:
        """Frame id of its positions on the wire."""
        return self.names.frame

    @property
    def h(self) -> float:
        """Time step [s]."""
        return self.integration.h

    @property
    def n(self) -> int:
        """Free degrees of freedom, the length of v."""
        return self.pattern.n

    @property
    def n_a(self) -> int:
        """Cables."""
        return self.cables.n_a

    @property
    def n_e(self) -> int:
        """Effector rows, three a point."""
        return 3 * len(self.effectors)

    @property
    def n_c(self) -> int:
        """Contact candidates, slots of λ_c."""
        return self.contacts.n_slots

    @property
    def linear_solver(self) -> str:
        """Name of the factorisation in use."""
        return self.factorisation.name

    @property
    def pairs(self) -> tuple[PairSlots, ...]:
        """Contact pairs in the order of their slots."""
        return self.contacts.pair_slots

    @property
    def cable_names(self) -> tuple[str, ...]:
        """Names of the cables, in the order of λ_a."""
        return self.names.cables

    @property
    def effector_names(self) -> tuple[str, ...]:
        """Names of the effectors, in row order."""
        return self.names.effectors

    def fork(self) -> Self:
        """The same robot with a separate factorisation workspace."""
        pattern, backend = self.pattern, self.factorisation.name
        workspace = make_factorisation(pattern.indptr, pattern.indices, backend)
        return dataclasses.replace(self, factorisation=workspace)

    @abstractmethod
    def forces(
        self, state: State, tension: Array | None = None, exact: bool = False
    ) -> tuple[Array, Array]:
        """Forces without cables and contacts (n,) [N], and K = −∂force/∂q as CSC values (nnz,).

        Args:
            state: where to evaluate.
            tension: (n_a,) tensions whose curvature enters the tangent [N]; None: none does.
            exact: exact derivative rather than the positive semidefinite tangent.
        """

    def linearise(
        self, state: State, tension: Array | None = None, integration: Integration | None = None
    ) -> System:
        """The system of one step from this state: A, b, v_free (7)-(10).

        Args:
            state: where the step starts.
            tension: (n_a,) last tensions, for the curvature they add to A [N].
            integration: another scheme than the robot's.

        Raises:
            FactorisationError: A is not positive definite (a state that has blown up).
        """
        scheme = integration or self.integration
        remembered, viscous = (None, None) if scheme.static else self.viscosity_at(state, scheme.h)
        for exact in (True, False):
            force, K = self.forces(state, tension, exact)
            if remembered is not None:
                force += remembered
            try:
                system = make_system(
                    self.pattern, self.factorisation, scheme, K, self.mass, force, state.v, viscous
                )
                return system if exact else dataclasses.replace(system, exact=False)
            except FactorisationError:
                # the exact tangent may be indefinite (buckling, compression); the other one is not
                if not exact:
                    raise
        raise AssertionError("unreachable")

    def viscosity_at(self, state: State, h: float) -> tuple[Array | None, Array | None]:
        """Forces (n,) of viscous materials' memory [N], and matrix C as CSC values (nnz,); None: no such.

        Args:
            state: where a step starts.
            h: its length [s].
        """
        return None, None

    @abstractmethod
    def velocity(self, start: State, end: State) -> Array:
        """The velocity (n,) that moves one state to another within a step [m/s], [rad/s]."""

    def momentum_force(self, start: State, v: Array) -> Array:
        """Derivative of ½ (v − v₀)ᵀ M (v − v₀) by the end of a step: (n,) [N].

        Args:
            start: of the step, with v₀.
            v: (n,) velocity of the step [m/s].
        """
        force: Array = self.mass * (v - start.v) / self.h
        return force

    @abstractmethod
    def potential(self, state: State) -> float:
        """Elastic energy minus the work of gravity and outer forces since rest [J]."""

    def energy(self, state: State) -> float:
        """Potential and kinetic energy, and that stored in viscous materials [J]."""
        return self.potential(state) + self.kinetic_energy(state.v)

    def kinetic_energy(self, v: Array) -> float:
        """½ vᵀ M v of velocities (n,) [J]."""
        return 0.5 * float(self.mass @ (v * v))

    def step_start(self, state: State, tension: Array, exact: bool) -> StepStart:
        """The start of a step that is iterated, with the damping there.

        Args:
            state: where the step starts.
            tension: (n_a,) tensions of the last step [N].
            exact: whether damping is proportional to the exact tangent, as in a step with one linearisation,
                or to the positive semidefinite one.
        """
        scheme = self.integration
        damping = np.zeros(len(self.pattern.indices))
        if scheme.rayleigh_stiffness > 0.0:
            damping = scheme.rayleigh_stiffness * self.forces(state, tension, exact)[1]
        damping[self.pattern.diagonal] += scheme.rayleigh_mass * self.mass
        remembered, viscous = self.viscosity_at(state, scheme.h)
        if viscous is not None:
            damping += viscous
        force = np.zeros(self.n) if remembered is None else remembered
        return StepStart(state, scheme, damping, force)

    def viscous_force(self, start: StepStart, v: Array) -> Array:
        """C v of velocities (n,): (n,) [N]."""
        pattern = self.pattern
        shape = (self.n, self.n)
        force: Array = (
            sp.csc_array((start.damping, pattern.indices, pattern.indptr), shape=shape) @ v
        )
        return force

    def dissipation(self, start: StepStart, v: Array) -> float:
        """½ h vᵀ C v − h vᵀ f of velocities (n,), f the constant forces of the step [J]."""
        return self.h * float(v @ (0.5 * self.viscous_force(start, v) - start.force))

    def linearise_iterate(self, state: State, start: StepStart, tension: Array) -> System:
        """The system of one iteration of a step that started elsewhere, without velocity of its own.

        Its solution dv moves the iterate by h dv.

        Args:
            state: the iterate.
            start: of the step.
            tension: (n_a,) tensions of the last iteration, for the curvature they add to A [N].

        Raises:
            FactorisationError: A is not positive definite.
        """
        v = self.velocity(start.state, state)
        inertia = self.momentum_force(start.state, v) + self.viscous_force(start, v) - start.force
        for exact in (True, False):
            force, K = self.forces(state, tension, exact)
            try:
                system = make_iterate(
                    self.pattern,
                    self.factorisation,
                    self.h,
                    K,
                    start.damping,
                    self.mass,
                    force - inertia,
                )
                return system if exact else dataclasses.replace(system, exact=False)
            except FactorisationError:
                if not exact:
                    raise
        raise AssertionError("unreachable")

    def no_contact_rows(self) -> ContactRows:
        """Contact rows with no candidate in range."""
        return ContactRows.out_of_range(sp.csr_array((0, self.n)), self.n_c)
