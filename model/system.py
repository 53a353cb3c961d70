"""The linear system of one step: a sparse pattern built once, values filled every step.

Implicit Euler with one linearisation, equations (3)-(8) of the paper:

    A dv = b + h Hᵀ λ,   A = M + h C + h² K,   b = h (f − C v − h K v)
    v_free = v + A⁻¹ b                                                            (10)

and its quasi-static limit, a Newton step for equilibrium: M, C and v vanish, A = h² K, b = h f. The damping
C = a M + b_K D is proportional to the stiffness D of the material, a semidefinite tangent without what the
actuators' efforts add: so C is positive semidefinite, and does not depend on the length of steps, as K may,
which is the exact tangent only where A has a Cholesky factor. D of corotational elements has their rotations
held: a viscosity that is proportional to their linear elasticity and turns with them.

Where the step is linearised at q + h v, to where the velocity alone leads, b = h (f − C v), and dv moves the
robot from there. Where a share a of that way counts as made, b = h (f − C v − (1 − a) h K v), K exact.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from tauten.model.numerics import Array, Bools, Factorisation, Ints, kernel
from tauten.model.schema import RobotConfig

# Shares of the semidefinite tangent that a step tries. The smaller it is, the faster steps converge.
SHARES = (0.0, 0.25, 1.0)
STATIC_SHARES = (0.0, 1.0 / 64.0, 1.0 / 8.0, 1.0)


class Scheme(NamedTuple):
    """Damping and time step; a tuple because kernels accept it directly.

    Attributes:
        h: time step [s].
        static: whether inertia and damping are left out.
        a: of the Rayleigh damping a M + b_K D [1/s].
        b_K: of the Rayleigh damping [s].
        ahead: share of the way to which the velocity leads in the step, that the state has made.
    """

    h: float
    static: bool
    a: float
    b_K: float
    ahead: float


class Tangent(NamedTuple):
    """A tangent that a step may use.

    Attributes:
        values: of K, as its body stores them.
        exact: whether it is the derivative of the forces.
        semidefinite: share of the positive semidefinite tangent in it that the next step may try first.
        stiffened: unknowns (d,), and what is added on the diagonal of the derivative there (d,), where
            that is all that it differs in; None: it does not differ so.
        unheld: unknowns (d,) that may go along with all else, and their stiffness alone (d,): where forces
            move them much farther than that, factors are those of rounding; None: there are none.
    """

    values: Array
    exact: bool
    semidefinite: float
    stiffened: tuple[Ints, Array] | None = None
    unheld: tuple[Ints, Array] | None = None


@dataclass(frozen=True)
class Integration:
    """How a step is taken.

    Attributes:
        rate: steps per second of simulated time [Hz].
        static: whether inertia and damping are left out (quasi-static).
        rayleigh_mass: a in C = a M + b_K D [1/s].
        rayleigh_stiffness: b_K [s].
        semidefinite: share of the positive semidefinite tangent that a quasi-static step tries first.
        ahead: share a of the way to which the velocity leads in the step, that the state which is linearised
            has made; 1: all of it, 0: none. Zero with a quasi-static step.
        aheads: of each part, where they differ; empty: all are `ahead`.
        viscous: whether materials have a viscosity of their own.
    """

    rate: float
    static: bool
    rayleigh_mass: float = 0.0
    rayleigh_stiffness: float = 0.0
    semidefinite: float = 0.0
    ahead: float = 0.0
    aheads: tuple[float, ...] = ()
    viscous: bool = False

    @cached_property
    def h(self) -> float:
        """Time step [s]."""
        return 1.0 / self.rate

    @cached_property
    def numbers(self) -> Scheme:
        """The scheme as kernels take it."""
        a, b_K = self.rayleigh_mass, self.rayleigh_stiffness
        return Scheme(self.h, self.static, a, b_K, self.ahead)

    @cached_property
    def shares(self) -> tuple[float, float]:
        """Factors h b_K and h² of the stiffness of the material D and the tangent K in A."""
        return 0.0 if self.static else self.h * self.rayleigh_stiffness, self.h * self.h

    @property
    def damped(self) -> bool:
        """Whether anything but the scheme itself damps motions."""
        return self.viscous or self.rayleigh_mass > 0.0 or self.rayleigh_stiffness > 0.0


def integration_of(config: RobotConfig) -> Integration:
    """The scheme and time step of a robot file."""
    scheme = config.integration
    return Integration(
        rate=config.controller.rate,
        static=scheme.scheme == "quasi-static",
        rayleigh_mass=scheme.rayleigh_mass,
        rayleigh_stiffness=scheme.rayleigh_stiffness,
    )


def tried_tangents(
    integration: Integration, exact: Array, semidefinite: Callable[[], Array]
) -> Iterator[Tangent]:
    """What a step tries until one has a Cholesky factor.

    Args:
        integration: of the step.
        exact: the derivative of the forces.
        semidefinite: gives the positive semidefinite tangent, asked once at most.
    """
    shares: tuple[float, ...] = SHARES
    if integration.static:
        shares = tuple(share for share in STATIC_SHARES if share >= integration.semidefinite)
    if shares[0] > 0.0:
        return _softer(shares, exact, semidefinite)
    return chain((Tangent(exact, True, 0.0),), _softer(shares[1:], exact, semidefinite))


def _softer(
    shares: tuple[float, ...], exact: Array, semidefinite: Callable[[], Array]
) -> Iterator[Tangent]:
    """Tangents with shares of the positive semidefinite one, all of which are positive."""
    other = semidefinite()
    for share in shares:
        if share < 1.0:
            yield Tangent((1.0 - share) * exact + share * other, False, share)
        else:
            yield Tangent(other, False, share)


def smaller_share(share: float) -> float:
    """The share of the semidefinite tangent below one of a quasi-static step."""
    return max((other for other in STATIC_SHARES if other < share), default=0.0)


@dataclass(frozen=True, slots=True)
class Pattern:
    """Sparsity of matrices over the free degrees of freedom.

    Attributes:
        dof: (n_nodes,) first degree of freedom of a node, −1 where it is fixed.
        indptr: (n + 1,) CSC column pointers.
        indices: (nnz,) row indices.
        diagonal: (n,) places of the diagonal in the values.
    """

    dof: Ints
    indptr: Ints
    indices: Ints
    diagonal: Ints

    @property
    def n(self) -> int:
        """Number of free degrees of freedom."""
        return len(self.indptr) - 1

    def matrix(self, values: Array) -> sp.csc_array:
        """A matrix (n, n) with values (nnz,) in this pattern, or (n,) on its diagonal."""
        if len(values) == self.n:
            return sp.csc_array(sp.diags_array(values))
        return sp.csc_array((values, self.indices, self.indptr), shape=(self.n, self.n))

    def add_block(self, values: Array, columns: Ints, block: Array) -> None:
        """Add a dense block of some unknowns, all of which the pattern couples.

        Args:
            values: (nnz,) of a matrix, added to.
            columns: (c,) the unknowns, ascending.
            block: (c, c) what is added to their rows and columns.
        """
        _add_block(self.indptr, self.indices, columns, block, values)

    def blocks(self, groups: Ints) -> tuple[Ints, Ints]:
        """Places of the 3x3 blocks that couple the nodes of each of groups (g, s).

        Returns:
            slot (g, s, s), place of entry (0, 0) of block (a, b), −1 where a node is fixed, and
            column_length (g, s), distance from one column of node b to the next.
        """
        g, s = groups.shape
        if g == 0:
            return np.zeros((0, s, s), dtype=np.int64), np.zeros((0, s), dtype=np.int64)
        lookup = sp.csc_array(
            (np.arange(1, len(self.indices) + 1), self.indices, self.indptr), shape=(self.n,) * 2
        )
        dof = self.dof[groups]  # (g, s)
        rows = np.repeat(dof, s, axis=1).ravel()
        columns = np.tile(dof, (1, s)).ravel()
        free = (rows >= 0) & (columns >= 0)
        slot = np.full(g * s * s, -1, dtype=np.int64)
        if free.any():  # SciPy returns a sparse array where it looks up nothing
            slot[free] = np.asarray(lookup[rows[free], columns[free]]).ravel() - 1
        length = np.diff(self.indptr)[np.maximum(dof, 0)]
        return slot.reshape(g, s, s), np.ascontiguousarray(length, dtype=np.int64)


def free_dof(fixed: Bools) -> Ints:
    """First degree of freedom of every node (n_nodes,), −1 of those that do not move, `fixed` (n_nodes,)."""
    dof: Ints = np.where(fixed, -1, 3 * (np.cumsum(~fixed) - 1))
    return dof


def make_pattern(fixed: Bools, groups: list[Ints]) -> Pattern:
    """Pattern in which all nodes of a group are coupled, in arrays (g, s), but the fixed ones (n_nodes,)."""
    dof = free_dof(fixed)
    number, m = dof // 3, int((~fixed).sum())  # −1 remains −1
    pairs = []
    for group in groups:
        s = group.shape[1]
        i = np.repeat(number[group], s, axis=1).ravel()
        j = np.tile(number[group], (1, s)).ravel()
        pairs.append(np.stack([i, j])[:, (i >= 0) & (j >= 0)])
    i, j = np.concatenate([np.tile(np.arange(m), (2, 1)), *pairs], axis=1)
    graph = sp.csc_array((np.ones(i.size), (i, j)), shape=(m, m))
    full = sp.csc_array(sp.kron(graph, np.ones((3, 3)), format="csc"))
    full.sort_indices()
    column = np.repeat(np.arange(3 * m), np.diff(full.indptr))
    return Pattern(
        dof=dof,
        indptr=full.indptr.astype(np.int64),
        indices=full.indices.astype(np.int64),
        diagonal=np.flatnonzero(full.indices == column),
    )


@kernel
def _add_block(indptr: Ints, indices: Ints, columns: Ints, block: Array, values: Array) -> None:
    """`Pattern.add_block`; rows of each column are ascending."""
    for b in range(columns.shape[0]):
        place = indptr[columns[b]]
        for a in range(columns.shape[0]):
            while indices[place] < columns[a]:
                place += 1
            values[place] += block[a, b]


@dataclass(frozen=True, slots=True)
class System:
    """A factorised A dv = b + h Hᵀ λ; valid until its factorisation is used for the next step.

    Attributes:
        h: time step [s].
        v: (n,) velocity before the step, less the share that has led its way already [m/s]; zero when
            quasi-static.
        v_free: (n,) velocity after a step without constraint forces (10), less that share [m/s].
        residual: norm of the forces out of balance, without constraints [N].
        factorisation: factors of A.
        exact: whether A has the exact tangent, which is then positive definite.
        tangent: in A of a quasi-static step, as the robot stores it; None where it is not kept.
        straight: whether nodes of beams move along straight lines where they could move along arcs.
        semidefinite: share of the positive semidefinite tangent in A, where it is known.
        stiffened: see `Tangent`, where the state has made nothing of the way; None: nothing is.
        inertia: (n,) centrifugal and gyroscopic forces at the start [N], 0 of static parts; None: all are.
    """

    h: float
    v: Array
    v_free: Array
    residual: float
    factorisation: Factorisation
    exact: bool = True
    tangent: Array | None = None
    straight: bool = False
    semidefinite: float = 0.0
    stiffened: tuple[Ints, Array] | None = None
    inertia: Array | None = None

    def solve(self, B: Array) -> Array:
        """A⁻¹ B for B (n, m), best column-major: (n, m)."""
        return self.factorisation.solve(B)


def make_system(
    pattern: Pattern,
    factorisation: Factorisation,
    integration: Integration,
    K: Array,
    mass: Array,
    force: Array,
    v: Array,
    damping: Array | None = None,
) -> System:
    """Build and factorise the system of one step.

    Args:
        pattern: sparsity of K.
        factorisation: overwritten with the factors of A.
        integration: scheme and damping.
        K: (nnz,) tangent values, kept where the step is quasi-static.
        mass: (n,) lumped mass [kg], or (nnz,) values of a mass matrix in the pattern.
        force: (n,) internal and external forces without constraints [N].
        v: (n,) velocity [m/s].
        damping: (nnz,) values of C without its part a M; None where the step is quasi-static.

    Raises:
        FactorisationError: A is not positive definite.
    """
    h = integration.h
    if integration.static:
        factorisation.refactor(h * h * K)
        dv = factorisation.solve(h * force)
        residual = float(np.linalg.norm(force))
        return System(h, np.zeros_like(v), dv, residual, factorisation, tangent=K)
    assert damping is not None
    scheme, values = integration.numbers, (mass, damping, K)
    A, resisting = _combined(pattern.indptr, pattern.indices, scheme, values, v)
    factorisation.refactor(A)
    dv = factorisation.solve(h * (force - resisting))
    before = (1.0 - integration.ahead) * v
    return System(h, before, before + dv, float(np.linalg.norm(force)), factorisation)


@kernel
def _combined(
    indptr: Ints, indices: Ints, scheme: Scheme, values: tuple[Array, Array, Array], v: Array
) -> tuple[Array, Array]:
    """Values (nnz,) of A = (1 + h a) M + h C + h² K, and (a M + C + (1 − ahead) h K) v (n,).

    Args:
        indptr: (n + 1,) CSC column pointers.
        indices: (nnz,) row indices.
        scheme: damping and time step.
        values: (nnz,) of M, or (n,) its diagonal, and (nnz,) of C without a M, and of K; all symmetric.
        v: (n,) velocity.
    """
    mass, C, K = values
    h, a, share = scheme.h, scheme.a, (1.0 - scheme.ahead) * scheme.h
    A, product, full = np.empty_like(K), np.empty_like(v), len(mass) == len(K)
    for column in range(v.shape[0]):
        total = 0.0  # of the column, which is the row
        for place in range(indptr[column], indptr[column + 1]):
            row, m = indices[place], 0.0
            if full:
                m = mass[place]
            elif row == column:
                m = mass[column]
            A[place] = (1.0 + h * a) * m + h * C[place] + h * h * K[place]
            total += (a * m + C[place] + share * K[place]) * v[row]
        product[column] = total
    return A, product


def make_iterate(
    factorisation: Factorisation, h: float, A: Array, force: Array, exact: bool
) -> System:
    """Build and factorise the system of one iteration of a step, (M + h C + h² K) dv = h force.

    Args:
        factorisation: overwritten with the factors.
        h: time step [s].
        A: M + h C + h² K, as the factorisation takes it.
        force: (n,) all forces without constraints, those of inertia and viscosity included [N].
        exact: whether K is the exact tangent.

    Raises:
        FactorisationError: A is not positive definite.
    """
    factorisation.refactor(A)
    dv = factorisation.solve(h * force)
    return System(h, np.zeros_like(dv), dv, float(np.linalg.norm(force)), factorisation, exact)
