"""The part of a sparse robot that time steps iterated to convergence need."""

from __future__ import annotations

import dataclasses
from abc import abstractmethod
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
import scipy.sparse as sp

from tauten.model.body.sparse_robot import SparseRobot
from tauten.model.numerics import Array, FactorisationError
from tauten.model.robot import State, StepStart
from tauten.model.system import System, make_iterate

P = TypeVar("P")


@dataclass(frozen=True, slots=True, eq=False)
class SteppedRobot(SparseRobot[P]):
    """A sparse robot with energies, and with systems of the iterations of a step.

    Its mass matrix is diagonal and constant.
    """

    @abstractmethod
    def velocity(self, start: State, end: State) -> Array:
        """The velocity (n,) that moves one state to another within a step [m/s], [rad/s]."""

    def at_end(self, start: State, end: State, force: Array) -> Array:
        """Forces (n,) at the end of a step that do the work of given ones at its start [N].

        Args:
            start: of the step.
            end: of the step.
            force: (n,) forces that do work on displacements v h [N].
        """
        return force

    def damping_at_end(self, start: StepStart, K: Array) -> Array:
        """Second derivative (nnz,) of ½ vᵀ C v by v h at the end of a step, where it may be approximated.

        Args:
            start: of the step, with C.
            K: (nnz,) tangent at the end.
        """
        return start.damping

    @abstractmethod
    def potential(self, state: State) -> float:
        """Elastic energy minus the work of gravity and outer forces since rest [J]."""

    def energy(self, state: State) -> float:
        """Potential and kinetic energy, and that stored in viscous materials [J]."""
        return self.potential(state) + self.kinetic_energy(state.v)

    def kinetic_energy(self, v: Array) -> float:
        """½ vᵀ M v of velocities (n,) [J]."""
        return 0.5 * float(self.mass @ (v * v))

    def step_start(self, state: State) -> StepStart:
        """The start of a step that is iterated, with the damping there.

        Args:
            state: where the step starts.
        """
        remembered, damping = self.damping_at(state, self.integration)
        damping[self.pattern.diagonal] += self.integration.rayleigh_mass * self.mass
        force = np.zeros(self.n) if remembered is None else remembered
        return StepStart(state, self.integration, damping, force)

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
        accelerated = self.mass * (v - start.state.v) / self.h
        resisting = accelerated + self.viscous_force(start, v) - start.force
        inertia = self.at_end(start.state, state, resisting)
        for exact in (True, False):
            force, K = self.forces(state, effort, exact)
            try:
                system = make_iterate(
                    self.pattern,
                    self.factorisation,
                    self.h,
                    K,
                    self.damping_at_end(start, K),
                    self.mass,
                    force - inertia,
                )
                return system if exact else dataclasses.replace(system, exact=False)
            except FactorisationError:
                if not exact:
                    raise
        raise AssertionError("unreachable")
