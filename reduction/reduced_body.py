"""Bodies in the coordinates of a state basis: their common part, and what a kind of body must supply."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import Any, Protocol, Self

import numpy as np
from typing_extensions import TypeVar

from tauten.model import Integration, Robot, State
from tauten.model.actuators import ActuatorSet
from tauten.model.body import Body
from tauten.model.effectors import Effectors
from tauten.model.numerics import Array, DenseFactors, Ints

P = TypeVar("P", default=Any)


class StateBasisError(ValueError):
    """A state basis that cannot be made or used; the text names what was found and what is expected."""


@dataclass(frozen=True, slots=True, eq=False)
class ReducedBody(Body[P]):
    """A body of r unknowns α that replaces a full one.

    Attributes, beside those of every body:
        full: the robot whose body it replaces.
        Phi: (m, r) state modes.
    """

    actuator_set: ActuatorSet[P]
    full: Robot
    Phi: Array

    @property
    def n(self) -> int:
        """Unknowns, r."""
        return int(self.Phi.shape[1])

    @property
    def n_nodes(self) -> int:
        """Nodes of the full body."""
        return self.full.n_nodes

    @property
    def moving_mass(self) -> float:
        """Mass of all nodes that are not fixed [kg]."""
        return self.full.body.moving_mass

    @property
    def size(self) -> float:
        """Largest distance between two nodes at rest [m]."""
        return self.full.size

    @property
    def stored_shape(self) -> tuple[int, ...]:
        """Shape of the values of a matrix: (r, r)."""
        return (self.n, self.n)

    @property
    def linear_solver(self) -> str:
        """Name of the solver of its linear systems."""
        return DenseFactors.name

    @property
    def triangles(self) -> Ints:
        """Surface of the full robot, indices into `points`: (t, 3)."""
        return self.full.triangles

    @property
    def chamber_owners(self) -> Ints:
        """The actuator whose chamber each of `triangles` encloses, −1 where none: (t,)."""
        return self.actuator_set.chamber_owners(self.triangles)

    def rest(self) -> State:
        """The stress-free state at standstill."""
        return State(np.zeros(self.n), np.zeros(self.n))

    def points(self, state: State) -> Array:
        """Positions of all points which `triangles` refers to (P, 3) [m]; as long as the mesh."""
        return self.full.points(self.lifted(state))

    def advance(self, state: State, v: Array, h: float, straight: bool = False) -> State:
        """The state one step later, v and α + h v, see `Robot`."""
        return State(state.q + h * v, v, state.memory)

    def loaded(self, gravity: Array, effector_force: Array, effectors: Effectors[P]) -> Self:
        """The body under other loads, see `Body`."""
        return self.of(self.full.loaded(gravity, effector_force))

    @abstractmethod
    def of(self, full: Any) -> Self:
        """The same reduction of a full robot (`Robot`) under other loads."""

    @abstractmethod
    def lifted(self, state: State) -> State:
        """The state of the full robot."""

    def matrix(self, values: Array) -> Array:
        """A matrix (r, r), which is stored as it is."""
        return values

    def add_mass(self, values: Array, mass: Array) -> None:
        """Add a mass matrix (r, r) to a matrix (r, r)."""
        values += mass

    def damping_at(self, state: State, scheme: Integration) -> tuple[Array | None, Array]:
        """No forces of memory, as materials are elastic, and C without a M (r, r)."""
        return None, scheme.rayleigh_stiffness * self.material_stiffness(state)

    @abstractmethod
    def material_stiffness(self, state: State) -> Array:
        """D (n, n), to which damping is proportional: positive semidefinite, without actuators."""

    def factors(self) -> DenseFactors:
        """A workspace for factors of matrices (r, r)."""
        return DenseFactors(np.zeros((self.n, self.n)))

    def inverted(self, state: State) -> int:
        """Number of elements of the full robot that are turned inside out."""
        return self.full.body.inverted(self.lifted(state))


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
    def kept_unknowns(self) -> Ints:
        """Unknowns (d,) of State.v of drives and of frames of regions, which no mode moves."""

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
        """Why a sample of elements (s,) with weights (s,) cannot be this body's: a sentence, or nothing."""

    def reduced(self, Phi: Array, elements: Ints, weights: Array) -> Robot[ReducedBody]:
        """The robot in the coordinates of a state basis.

        Args:
            Phi: (m, r) state modes.
            elements: (s,) sampled elements.
            weights: (s,) their weights.
        """
