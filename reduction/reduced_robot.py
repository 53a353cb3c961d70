"""The common part of reduced robots, and what a kind of body must supply to have one."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from tauten.model import (
    Actuators,
    Assembled,
    EffectorLayout,
    Integration,
    Layout,
    Limits,
    PairSlots,
    Robot,
    RobotRows,
    State,
    System,
    row_layout,
)
from tauten.model.numerics import Array, DenseFactors, Ints


class StateBasisError(ValueError):
    """A state basis that cannot be made or used; the text names what was found and what is expected."""


@dataclass(frozen=True, slots=True, eq=False)
class ReducedRobot(ABC):
    """A `Robot` of r unknowns α that replaces a full one.

    Attributes:
        full: the robot it replaces.
        Phi: (m, r) state modes.
        integration: time step and scheme.
    """

    full: Robot
    Phi: Array
    integration: Integration

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
        return int(self.Phi.shape[1])

    @property
    def n_a(self) -> int:
        """Actuators; couplings count as one."""
        return len(self.full.actuators)

    @property
    def layout(self) -> Layout:
        """Where the rows of effectors, actuators and contacts are in a step."""
        return row_layout(self.effector_layout.n_rows, self.n_a)

    @property
    def effector_layout(self) -> EffectorLayout:
        """Kinds of the effectors, their rows, goal values and weights."""
        return self.full.effector_layout

    @property
    def n_c(self) -> int:
        """Contact candidates, slots of λ_c."""
        return self.full.n_c

    @property
    def n_nodes(self) -> int:
        """Nodes of the full robot."""
        return self.full.n_nodes

    @property
    @abstractmethod
    def n_elements(self) -> int:
        """Elements in the sample."""

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

    @property
    def segment_owners(self) -> Ints:
        """The actuator of every segment that `actuator_segments` gives: (s,)."""
        return self.full.segment_owners

    @property
    def chamber_owners(self) -> Ints:
        """The actuator whose chamber each of `triangles` encloses, −1 where none: (t,)."""
        return self.full.chamber_owners

    def actuator_segments(self, state: State) -> Array:
        """Both ends of every straight piece of the cables: (s, 2, 3) [m]; as long as the mesh."""
        return self.full.actuator_segments(self.lifted(state))

    def rest(self) -> State:
        """The stress-free state at standstill."""
        return State(np.zeros(self.n), np.zeros(self.n))

    def points(self, state: State) -> Array:
        """Positions of all points which `triangles` refers to (P, 3) [m]; as long as the mesh."""
        return self.full.points(self.lifted(state))

    def advance(self, state: State, system: System, dv: Array) -> State:
        """The state one step later: v + dv and α + h (v + dv).

        Args:
            state: before the step.
            system: of this step; its v is zero when quasi-static.
            dv: (r,) change of the velocity.
        """
        v = system.v + dv
        return State(state.q + system.h * v, v)

    @abstractmethod
    def fork(self) -> ReducedRobot:
        """The same robot with a workspace of its own."""

    @abstractmethod
    def loaded(self, gravity: Array, effector_force: Array) -> ReducedRobot:
        """The robot under another gravity (3,) [m/s²] and forces on its effectors (3 p,) [N]."""

    @abstractmethod
    def lifted(self, state: State) -> State:
        """The state of the full robot."""

    @abstractmethod
    def projected(self, state: State) -> State:
        """The nearest state to one of the full robot."""

    @abstractmethod
    def effector(self, state: State) -> Array:
        """Positions of the effectors: (p, 3) [m]."""

    @abstractmethod
    def effector_values(self, state: State) -> Array:
        """Goal values of the effectors: (n_v,)."""

    @abstractmethod
    def candidates(self, state: State) -> Array:
        """Positions of the contact candidates: (n_c, 3) [m]."""

    @abstractmethod
    def displacement(self, state: State, dq: Array) -> float:
        """Largest displacement of an effector or contact vertex in a change dq (r,) at a state, about [m]."""

    @abstractmethod
    def forces(
        self, state: State, effort: Array | None = None, exact: bool = False
    ) -> tuple[Array, Array]:
        """Forces without actuators and contacts (r,), and the tangent K (r, r).

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
            integration: replaces the robot's own scheme.

        Raises:
            FactorisationError: A is not positive definite (a state that has blown up).
        """
        scheme = integration or self.integration
        return self.system(self.assemble(state, effort, scheme), scheme)

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

    @abstractmethod
    def rows(self, state: State, contacts: bool = True) -> RobotRows:
        """Rows of effectors, actuators and, where `contacts` is true, contacts at this state."""


@dataclass(frozen=True, slots=True, eq=False)
class ElementSample:
    """Sampled elements and their weights.

    Attributes:
        elements: (s,) their numbers, ascending.
        weights: (s,) factors of their forces.
        error: relative residual of the sampled sums at the training states.
    """

    elements: Ints
    weights: Array
    error: float


class Reducible(Protocol):
    """A full robot as state reduction sees it: coordinates whose deviations from rest are Φ α, and elements.

    Robots made of tetrahedra and of beams each have an implementation.
    """

    @property
    def own_coordinates(self) -> int:
        """How many of the last deviations no mode combines: the reduced robot has them as coordinates."""

    @property
    def weight(self) -> Array:
        """Diagonal W (m,) of the norm in which modes are orthonormal: ΦᵀWΦ = I."""

    @property
    def norm(self) -> str:
        """What W is, in a word."""

    @property
    def default_motion(self) -> float:
        """Relative projection error in this norm that a basis is allowed unless another one is given."""

    @property
    def n_elements(self) -> int:
        """Number of elements that a sample is taken from."""

    def deviations(self, q: Array) -> Array:
        """Deviations from rest (m, s) of configurations of the full robot (n_q, s)."""

    def rates(self, q: Array, motion: Array) -> Array:
        """Rates of the deviations (m, k) of velocities (n, k) at a configuration (n_q,)."""

    def sample(self, Phi: Array, alphas: Array, tolerance: float, seed: int) -> ElementSample:
        """A sample of elements for the states with deviations Φ α.

        Args:
            Phi: (m, r) state modes.
            alphas: (r, s) states of a campaign; some of them are training states.
            tolerance: relative residual.
            seed: of random directions.
        """

    def implausible(self, elements: Ints, weights: Array) -> str:
        """Why a sample of elements cannot be this body's: a sentence, or nothing.

        Args:
            elements: (s,) numbers, in range.
            weights: (s,) their weights.
        """

    def reduced(self, Phi: Array, elements: Ints, weights: Array) -> ReducedRobot:
        """The robot in the coordinates of a state basis.

        Args:
            Phi: (m, r) state modes.
            elements: (s,) sampled elements.
            weights: (s,) their weights.
        """
