"""The common part of robots with a sparse tangent."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Self, TypeVar

import numpy as np
import scipy.sparse as sp

from tauten.model.body.robot_base import RobotBase
from tauten.model.numerics import Array, Factorisation, FactorisationError, Ints
from tauten.model.robot import Assembled, State
from tauten.model.system import (
    Integration,
    Pattern,
    System,
    make_system,
    semidefinite_shares,
)

P = TypeVar("P")


@dataclass(frozen=True, slots=True)
class SparseAssembled(Assembled):
    """Forces and tangents of a robot with a sparse tangent; attributes beside those of `Assembled`.

    Attributes:
        force: (n,) without actuators, contacts and viscosity [N].
        K: (nnz,) exact tangent.
        D: (nnz,) stiffness to which damping is proportional; None: no damping is.
    """

    force: Array
    K: Array
    D: Array | None


@dataclass(frozen=True, slots=True, eq=False)
class SparseRobot(RobotBase[P]):
    """The linear system of a `Robot` that has a pattern and a factorisation.

    Attributes, beside those of every robot:
        pattern: sparsity of its matrices.
        factorisation: workspace of the linear solver.
    """

    pattern: Pattern
    factorisation: Factorisation

    @property
    def n(self) -> int:
        """Free degrees of freedom, the length of v."""
        return self.pattern.n

    @property
    def linear_solver(self) -> str:
        """Name of the factorisation in use."""
        return self.factorisation.name

    def fork(self) -> Self:
        """The same robot with a separate factorisation workspace."""
        return dataclasses.replace(self, factorisation=self.factorisation.fork())

    def assemble(
        self, state: State, effort: Array | None = None, integration: Integration | None = None
    ) -> SparseAssembled:
        """Forces and tangents at a state.

        Args:
            state: where steps start.
            effort: (n_a,) last efforts of the actuators, for the curvature they add to A.
            integration: another scheme than the robot's. The steps may have any length, but its damping.
        """
        D = self.stiffness_of(state, integration or self.integration)
        return SparseAssembled(state, effort, *self.forces(state, effort, exact=True), D)

    def system(self, assembled: Assembled, integration: Integration) -> System:
        """The system of one step, `linearise` where forces and tangents are known.

        Args:
            assembled: by this robot or a fork.
            integration: scheme and length of the step.

        Raises:
            FactorisationError: A is not positive definite (a state that has blown up).
        """
        assert isinstance(assembled, SparseAssembled)
        state, force, K, scheme = assembled.state, assembled.force, assembled.K, integration
        damping: Array | None = None
        if not scheme.static:
            remembered, damping = self.damping_with(assembled.D, state, scheme)
            force = force if remembered is None else force + remembered
        semidefinite: Array | None = None
        for share in semidefinite_shares(scheme):
            if share > 0.0 and semidefinite is None:
                semidefinite = self.forces(state, assembled.effort, exact=False)[1]
            tangent = K
            if semidefinite is not None and share < 1.0:
                tangent = (1.0 - share) * K + share * semidefinite
            elif semidefinite is not None:
                tangent = semidefinite
            try:
                system = make_system(
                    self.pattern,
                    self.factorisation,
                    scheme,
                    tangent,
                    self.masses(state),
                    force,
                    state.v,
                    damping,
                )
                return dataclasses.replace(system, exact=share == 0.0, semidefinite=share)
            except FactorisationError:
                # the exact tangent may be indefinite (buckling, compression); the semidefinite one is not
                if share == 1.0:
                    raise
        raise AssertionError("unreachable")

    @property
    def motor_coordinates(self) -> Ints:
        """Degrees of freedom that a motor holds, none by default."""
        return np.zeros(0, dtype=np.int64)

    def mass_matrix(self, state: State) -> sp.csc_array:
        """The mass matrix (n, n) at a state."""
        return self.matrix(self.masses(state))

    def matrix(self, values: Array) -> sp.csc_array:
        """A matrix (n, n) of this robot, from values (nnz,) in its pattern or (n,) on the diagonal."""
        return self.pattern.matrix(values)

    def add_mass(self, values: Array, mass: Array) -> None:
        """Add masses, see `masses`, to the values (nnz,) of a matrix."""
        values[self.pattern.diagonal if len(mass) == self.n else slice(None)] += mass

    def factors(self) -> Factorisation:
        """The workspace of the linear solver."""
        return self.factorisation

    def damping_at(self, state: State, scheme: Integration) -> tuple[Array | None, Array]:
        """Forces (n,) of viscous materials' memory [N] or None, and C without a M as CSC values (nnz,).

        Args:
            state: where a step is linearised.
            scheme: its length and damping.
        """
        return self.damping_with(self.stiffness_of(state, scheme), state, scheme)

    def damping_with(
        self, D: Array | None, state: State, scheme: Integration
    ) -> tuple[Array | None, Array]:
        """`damping_at` where the stiffness is known.

        Args:
            D: (nnz,) of `stiffness_of`.
            state: where a step is linearised.
            scheme: its length and damping.
        """
        damping = np.zeros(len(self.pattern.indices))
        if D is not None:
            damping = scheme.rayleigh_stiffness * D
        remembered, viscous = self.viscosity_at(state, scheme.h)
        if viscous is not None:
            damping += viscous
        return remembered, damping

    def stiffness_of(self, state: State, scheme: Integration) -> Array | None:
        """`stiffness` at a state where the damping of a scheme needs it, else None."""
        needed = scheme.rayleigh_stiffness > 0.0 and not scheme.static
        return self.stiffness(state) if needed else None

    def stiffness(self, state: State) -> Array:
        """D, to which damping is proportional: positive semidefinite, without actuators, as CSC (nnz,)."""
        return self.forces(state)[1]

    def viscosity_at(self, state: State, h: float) -> tuple[Array | None, Array | None]:
        """Forces (n,) of viscous materials' memory [N], and matrix C as CSC values (nnz,); None: no such.

        Args:
            state: where a step starts.
            h: its length [s].
        """
        return None, None
