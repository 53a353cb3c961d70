"""Where a robot is in a step, and what is known there."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from tauten.model.numerics import Array
from tauten.model.rows import ContactRows, EffectorRows, Rows
from tauten.model.system import Integration

# Added to a tangent: (r, r) of a body with dense matrices, or that of each part; None: nothing.
Augmentation: TypeAlias = Array | tuple["Augmentation", ...] | None


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
    """Forces and tangents at a state, of which `Body.system` makes systems; each kind of body adds its own.

    Attributes:
        state: where they were evaluated.
        effort: (n_a,) efforts of the actuators whose curvature is in the tangent; None: none is.
    """

    state: State
    effort: Array | None

    def augmentation(self, H: Array, rho: Array) -> tuple[Augmentation, Array]:
        """What adds ρ_i h_iᵀ h_i to the tangent for rows H (m, n), as in augmented Lagrangian methods.

        A body adds what it can: matrices that are dense. The stiffness rho (m,) of a row may be zero.

        Returns:
            What `Body.system` takes, and the stiffness (m,) that it adds.
        """
        return None, np.zeros_like(rho)


@dataclass(frozen=True, slots=True)
class StepStart:
    """Where a time step that is iterated starts.

    Attributes:
        state: configuration and velocity there.
        integration: scheme and time step.
        mass: the mass matrix M there, as the body stores it.
        damping: the matrix C of the viscous forces −C v in the step, as the body stores it.
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
