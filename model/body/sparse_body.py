"""The common part of bodies with a sparse tangent."""

from __future__ import annotations

import dataclasses
from abc import abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Self

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components
from typing_extensions import TypeVar

from tauten.model.actuators import ActuatorSet
from tauten.model.body.body import Body
from tauten.model.numerics import Array, Bools, Factorisation, FactorisationError, Ints
from tauten.model.state import Assembled, Augmentation, State
from tauten.model.system import (
    Integration,
    Pattern,
    System,
    Tangent,
    make_system,
    tried_tangents,
)

P = TypeVar("P", default=Any)

NEARLY = 1e-6  # of what was added on the diagonal: closer to singular, rounding might decide
# Of the stiffness of an unknown alone: less with all else that goes along is rounding
ROUNDING = 1e-9


@dataclass(frozen=True, slots=True)
class SparseAssembled(Assembled):
    """Forces and tangents of a body with a sparse tangent; attributes beside those of `Assembled`.

    Attributes:
        force: (n,) without actuators, contacts and viscosity [N].
        K: (nnz,) exact tangent.
        D: (nnz,) stiffness to which damping is proportional; None: no damping is.
        mass: as `SparseBody.masses` gives it; empty where steps are static.
        inertia: (n,) centrifugal and gyroscopic forces [N]; None: there are none.
    """

    force: Array
    K: Array
    D: Array | None
    mass: Array
    inertia: Array | None


@dataclass(slots=True)
class Past:
    """What a workspace remembers of its last system; it decides what is tried first, not what is found.

    Attributes:
        indefinite: whether the exact tangent had no factor, but did with more on its diagonal.
    """

    indefinite: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class SparseBody(Body[P]):
    """The linear system of a body that has a pattern and a factorisation.

    Attributes, beside those of every body:
        pattern: sparsity of its matrices.
        factorisation: workspace of the linear solver.
        floating: (n,) which degrees of freedom move by their inertia in quasi-static steps too: those of
            bodies that nothing holds.
        past: what the workspace remembers.
    """

    actuator_set: ActuatorSet[P]
    pattern: Pattern
    factorisation: Factorisation
    floating: Bools
    past: Past = field(default_factory=Past, init=False)

    @property
    def n(self) -> int:
        """Free degrees of freedom, the length of v."""
        return self.pattern.n

    @property
    def stored_shape(self) -> tuple[int, ...]:
        """Shape of the values of a matrix: (nnz,)."""
        return (len(self.pattern.indices),)

    @property
    def components(self) -> Ints:
        """Number of the set of each unknown (n,): bodies that nothing joins."""
        joined = self.pattern.matrix(np.ones(self.stored_shape))
        numbers: Ints = connected_components(joined, directed=False)[1].astype(np.int64)
        return numbers

    @property
    def linear_solver(self) -> str:
        """Name of the factorisation in use."""
        return self.factorisation.name

    @property
    def chamber_owners(self) -> Ints:
        """The actuator whose chamber each of `triangles` encloses, −1 where none: (t,)."""
        return self.actuator_set.chamber_owners(self.triangles)

    @property
    def of_beams(self) -> bool:
        """Whether beams are all that deforms."""
        return False

    def fork(self) -> Self:
        """The same body with a separate factorisation workspace."""
        return dataclasses.replace(self, factorisation=self.factorisation.fork())

    def assemble(
        self, state: State, effort: Array | None = None, integration: Integration | None = None
    ) -> SparseAssembled:
        """Forces and tangents at a state, see `Body`."""
        scheme = integration or self.integration
        D, mass, inertia = None, np.zeros(0), None
        if stiffness_counts(scheme):
            force, K, D = self.forces_and_stiffness(state, effort)
        else:
            force, K = self.forces(state, effort, exact=True)
        if not scheme.static:
            mass, inertia = self.masses(state), self.inertia_at(state)
        elif (floating := self.floating_mass(state)) is not None:
            state = dataclasses.replace(state, v=self.floating_velocity(state))
            mass, inertia = floating, self.inertia_at(state)
        return SparseAssembled(state, effort, force, K, D, mass, inertia)

    @property
    def floats(self) -> bool:
        """Whether any degree of freedom is `floating`."""
        return bool(self.floating.any())

    def floating_mass(self, state: State) -> Array | None:
        """Mass, see `masses`, of what moves by its inertia in quasi-static steps too; None: nothing does."""
        if not self.floats:
            return None
        mass = self.masses(state)
        own = self.floating if len(mass) == self.n else self.floating[self.pattern.indices]
        return np.where(own, mass, 0.0)

    def floating_velocity(self, state: State) -> Array:
        """Velocity (n,) of what is `floating`, zero of all else."""
        return np.where(self.floating, state.v, 0.0)

    def system(
        self, assembled: Assembled, integration: Integration, added: Augmentation = None
    ) -> System:
        """The system of one step, `Robot.linearise` where forces and tangents are known, see `Body`."""
        assert isinstance(assembled, SparseAssembled)
        at, scheme, force = assembled, integration, assembled.force
        if at.inertia is not None:
            force = force + at.inertia
        damping: Array | None = None
        if not scheme.static:
            remembered, damping = self.damping_with(at.D, at.state, scheme)
            force = force if remembered is None else force + remembered
        elif self.floats:
            # mass and velocity of all else are zero: its step stays quasi-static
            scheme, damping = dataclasses.replace(scheme, static=False), np.zeros_like(at.K)
            at = dataclasses.replace(at, inertia=None)  # `force` has it
        made = partial(self._system_with, at, scheme, force, damping)
        failed: FactorisationError | None = None
        put_off: Tangent | None = None
        for tangent in self.tangents(at, integration):
            if tangent.exact and self.past.indefinite:
                put_off = tangent
                continue
            try:
                system = made(tangent)
            except FactorisationError as error:
                failed, put_off = error, None  # what is less stiff has no factor either
                continue
            if put_off is not None and not indefinite_without(system, tangent.stiffened):
                try:
                    system = made(put_off)
                except FactorisationError:
                    system = made(tangent)
            self.past.indefinite = not system.exact and tangent.stiffened is not None
            return system
        assert failed is not None
        raise failed

    def _system_with(
        self,
        at: SparseAssembled,
        scheme: Integration,
        force: Array,
        damping: Array | None,
        tangent: Tangent,
    ) -> System:
        """`system` with one of the tangents.

        The force (n,) is without constraints [N], the damping (nnz,) is C without a M; None: the step is
        quasi-static.

        Raises:
            FactorisationError: A has no Cholesky factor, or one of rounding.
        """
        K, v, exact = tangent.values, at.state.v, tangent.exact
        system = make_system(
            self.pattern, self.factorisation, scheme, K, at.mass, force, v, damping
        )
        lost = tangent.unheld is not None and has_lost_digits(
            system.factorisation, scheme.h, len(v), tangent.unheld
        )
        if lost:
            raise FactorisationError("the tangent is singular within rounding")
        v_free = system.v_free
        if 0.0 < scheme.ahead < 1.0 and not (exact or self.of_beams):  # the derivative leads on
            less = self.pattern.matrix(K - at.K) @ v
            v_free = v_free + (1.0 - scheme.ahead) * scheme.h**2 * system.solve(less)
        share, more = tangent.semidefinite, tangent.stiffened if scheme.ahead == 0.0 else None
        return dataclasses.replace(
            system,
            v_free=v_free,
            exact=exact,
            semidefinite=share,
            stiffened=more,
            inertia=at.inertia,
        )

    def tangents(self, at: SparseAssembled, scheme: Integration) -> Iterator[Tangent]:
        """What a step tries until one has a Cholesky factor.

        The exact tangent may be indefinite (buckling, compression); the last one, which is semidefinite, has
        a factor unless the state has blown up.
        """
        return self.tried(at, scheme, lambda: self.semidefinite(at, scheme))

    def tried(
        self, at: SparseAssembled, scheme: Integration, semidefinite: Callable[[], Array]
    ) -> Iterator[Tangent]:
        """`tangents` where the semidefinite one is known.

        Plans of beams have no other. At given efforts an arm that tendons compress is nearly unstable over
        their horizon, or unstable, though it is stable at given positions: its exact tangent has a factor in
        some ticks and none in others, and tensions would go up and down. It does not lead a velocity on
        either, as it does of other bodies: stress of beams changes from tick to tick and turns with them over
        a horizon, while the derivative has it fixed in direction. Axial forces of an arm that moves fast
        would push its tip far aside.

        Args:
            at: where the step is linearised.
            scheme: of the step; a plan is longer than a tick.
            semidefinite: gives the positive semidefinite tangent (nnz,), asked once at most.
        """
        if scheme.static or scheme.h <= self.h or not self.of_beams:
            return tried_tangents(scheme, at.K, semidefinite)
        return iter((Tangent(semidefinite(), False, 1.0),))

    def semidefinite(self, at: SparseAssembled, scheme: Integration) -> Array:
        """The positive semidefinite tangent (nnz,) of a step; in time steps of beams without their cables.

        It leaves out what compression takes from the stiffness of beams, and where cables run along them the
        curvature under the tension of the cables adds as much: one without the other makes an arm of tendons
        many times as stiff as it is. Steps towards an equilibrium keep it, which makes them shorter.
        """
        if scheme.static or not self.of_beams:
            return self.forces(at.state, at.effort, exact=False)[1]
        return self.stiffness(at.state) if at.D is None else at.D

    def matrix(self, values: Array) -> sp.csc_array:
        """A matrix (n, n) of this body, from values (nnz,) in its pattern or (n,) on the diagonal."""
        return self.pattern.matrix(values)

    def add_mass(self, values: Array, mass: Array) -> None:
        """Add masses, see `masses`, to the values (nnz,) of a matrix."""
        values[self.pattern.diagonal if len(mass) == self.n else slice(None)] += mass

    def factors(self) -> Factorisation:
        """The workspace of the linear solver."""
        return self.factorisation

    def damping_at(self, state: State, scheme: Integration) -> tuple[Array | None, Array]:
        """Forces (n,) of viscous materials' memory [N] or None, and C without a M as CSC values (nnz,).

        See `Body`.
        """
        D = self.stiffness(state) if stiffness_counts(scheme) else None
        return self.damping_with(D, state, scheme)

    def damping_with(
        self, D: Array | None, state: State, scheme: Integration
    ) -> tuple[Array | None, Array]:
        """`damping_at` where the stiffness is known.

        Args:
            D: (nnz,) of `stiffness`; None: no damping is proportional to it.
            state: where a step is linearised.
            scheme: its length and damping.
        """
        size = len(self.pattern.indices)
        damping: Array = np.zeros(size) if D is None else scheme.rayleigh_stiffness * D
        remembered, viscous = self.viscosity_at(state, scheme.h)
        if viscous is not None:
            damping += viscous
        return remembered, damping

    def forces_and_stiffness(
        self, state: State, effort: Array | None
    ) -> tuple[Array, Array, Array]:
        """`forces` with the exact tangent, and `stiffness`; in one pass where a body can."""
        return (*self.forces(state, effort, exact=True), self.stiffness(state))

    @abstractmethod
    def stiffness(self, state: State) -> Array:
        """D, to which damping is proportional: positive semidefinite, without actuators, as CSC (nnz,)."""

    def viscosity_at(self, state: State, h: float) -> tuple[Array | None, Array | None]:
        """Forces (n,) of viscous materials' memory [N], and C as CSC (nnz,), in a step of h [s], or None."""
        return None, None


def indefinite_without(system: System, stiffened: tuple[Ints, Array] | None) -> bool:
    """Whether A of a system is indefinite without what was added on its diagonal, by its Schur complement.

    With S (d,) added on some unknowns E (d,), which is `stiffened`, A − E S Eᵀ is positive definite exactly
    where 1 − √S Eᵀ A⁻¹ E √S is, which is as small as the number of these. False also where rounding might
    decide, and where nothing is known.
    """
    if stiffened is None:
        return False
    unknowns, added = stiffened
    E = np.zeros((len(system.v_free), len(unknowns)), order="F")
    E[unknowns, np.arange(len(unknowns))] = system.h * np.sqrt(added)
    left = np.eye(len(unknowns)) - E.T @ system.solve(E)
    return bool(np.linalg.eigvalsh(left)[0] < -NEARLY)


def has_lost_digits(factors: Factorisation, h: float, n: int, unheld: tuple[Ints, Array]) -> bool:
    """Whether factors of a quasi-static tangent exist by rounding alone.

    Args:
        factors: of A = h² K (n, n).
        h: time step [s].
        n: number of unknowns.
        unheld: see `Tangent`.
    """
    unknowns, stiffness = unheld
    E = np.zeros((n, len(unknowns)), order="F")
    E[unknowns, np.arange(len(unknowns))] = h
    compliance = np.sum(E * factors.solve(E), axis=0)  # m/N, 1 / stiffness or more
    return bool((compliance * stiffness * ROUNDING > 1.0).any())


def stiffness_counts(scheme: Integration) -> bool:
    """Whether the damping of a scheme is proportional to the stiffness of the material."""
    return scheme.rayleigh_stiffness > 0.0 and not scheme.static
