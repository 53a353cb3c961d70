"""Inverse control with Coulomb friction: what is to be solved.

    min  f(λ, r) = 1/2 z'Qz + c'z + constant,   z = (λ, r)                                     (I1)
    s.t. lb <= λ <= ub,   g_lo <= G z <= g_hi                                                  (I2)
         u = W_cc r + W_ca λ + q,   K* ∋ u + μ |u_t| n ⟂ r ∈ K = {|r_t| <= μ r_n}              (I3)

(I1) and (I2) are those of a QPCC; in place of its complementarity every contact has the cone of (I3), whose
rows follow one another, the normal first. Rows of single contacts without friction, as columns of a contact
basis are, come before them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.linalg.lapack import dpstrf

from tauten.controller.qpcc import Qpcc
from tauten.model.friction import Cones, padded_places, padded_rows
from tauten.model.numerics import Array, Ints, kernel

RANK = 1e-12  # of the largest diagonal entry, pivots of the factor of W_cc below which it ends


@dataclass(frozen=True, slots=True)
class FrictionInverse:
    """An inverse problem (I1)-(I3); n = n_a + s + 3 k variables.

    Attributes:
        program: objective and limits; its rows M z + m, (s + 3 k) of them, are the displacements u. The
            objective is in the square of the unit of u.
        friction: (k,) coefficients of the last k contacts, which have three rows each.
        exact: error of the natural map up to which contact forces count as exact [unit of u].
        enough: objective that need not become lower.
        near: objective without that of the efforts, up to which nothing out of sight is looked for.
        energy: (n_a, n_a) part of Q that weighs efforts rather than what they move; None: zero.

    Raises:
        ValueError: shapes or values that do not fit; the message says which.
    """

    program: Qpcc
    friction: Array
    exact: float = 1e-8
    enough: float = 0.0
    near: float = 0.0
    energy: Array | None = None

    def __post_init__(self) -> None:
        """Check shapes and values."""
        if 3 * len(self.friction) > len(self.program.m) or len(self.program.m) == 0:
            raise ValueError(
                f"friction: found {len(self.friction)} contacts of three rows, expected one or more "
                f"contacts in {len(self.program.m)} rows"
            )
        if not (np.isfinite(self.friction).all() and (self.friction >= 0.0).all()):
            raise ValueError(
                "friction: found a value that is negative or not finite, expected 0 or more"
            )

    @property
    def n_a(self) -> int:
        """Number of efforts."""
        return len(self.program.lb)

    @property
    def singles(self) -> int:
        """Rows of single contacts s."""
        return len(self.program.m) - 3 * len(self.friction)


class InverseContacts(NamedTuple):
    """The contacts of an inverse problem with three rows each; m contacts.

    A single row has two more, with its own compliance and neither motion nor friction.

    Attributes:
        W: (3 m, 3 m) compliance.
        W_ca: (3 m, n_a) of contacts under efforts.
        q: (3 m,) displacements without forces.
        mu: (m,) coefficients of friction.
        w: (m,) largest compliance of each contact, along its normal or in any direction across it.
        G: (3 m, rank) with W = G Gᵀ but for the rows that were added: the state form.
        exact: error of the natural map up to which forces count as exact.
    """

    W: Array
    W_ca: Array
    q: Array
    mu: Array
    w: Array
    G: Array
    exact: float


@kernel
def cones_at(contacts: InverseContacts, lam: Array) -> Cones:
    """The contacts at efforts (n_a,)."""
    q = contacts.q + np.dot(contacts.W_ca, lam)
    return Cones(contacts.W, q, contacts.mu, contacts.w)


def normals_alone(problem: FrictionInverse) -> tuple[Qpcc, Ints]:
    """The QPCC of the same contacts without friction, and the rows (s + k,) that it has of this problem's."""
    program, n_a = problem.program, problem.n_a
    rows = np.concatenate(
        [np.arange(problem.singles), np.arange(problem.singles, len(program.m), 3)]
    )
    z = np.concatenate([np.arange(n_a), n_a + rows])
    alone = replace(
        program, Q=program.Q[z[:, None], z], c=program.c[z], G=program.G[:, z],
        M=program.M[rows[:, None], z], m=program.m[rows],
    )  # fmt: skip
    return alone, rows


def contact_rows(problem: FrictionInverse) -> Ints:
    """Where each row (s + 3 k,) of a problem is among those of contacts with three rows each."""
    return padded_places(len(problem.program.m), len(problem.friction))


def inverse_contacts(problem: FrictionInverse) -> InverseContacts:
    """Contacts with three rows each and a factor of their compliance, of a problem.

    Contacts that nothing moves, on what is fixed, are open: no force acts on what does not move.
    """
    program, n_a = problem.program, problem.n_a
    M = np.ascontiguousarray(program.M)
    root = symmetric_root(M[:, n_a:], RANK * largest_entry(M, n_a))  # (s + 3 k, rank)
    return padded_contacts(M, program.m, problem.friction, root, problem.exact)


@kernel
def largest_entry(M: Array, n_a: int) -> float:
    """The largest compliance of the contacts, at least next to nothing.

    Args:
        M: (m, n_a + m) rows of the contacts.
        n_a: number of efforts.
    """
    largest = 1e-300
    for i in range(len(M)):
        largest = max(largest, M[i, n_a + i])
    return largest


@kernel
def padded_contacts(M: Array, m: Array, mu: Array, root: Array, exact: float) -> InverseContacts:
    """Rows of a problem as contacts with three rows each.

    Args:
        M: (s + 3 k, n_a + s + 3 k) rows of the contacts.
        m: (s + 3 k,) displacements without forces.
        mu: (k,) coefficients of friction.
        root: (s + 3 k, rank) factor of their compliance.
        exact: error of the natural map up to which forces count as exact.
    """
    n_a = M.shape[1] - len(M)
    W, q, friction, w = padded_rows(M[:, n_a:], m, mu)
    W_ca, G = np.zeros((len(q), n_a)), np.zeros((len(q), root.shape[1]))
    for i, row in enumerate(padded_places(len(m), len(mu))):
        W_ca[row], G[row] = M[i, :n_a], root[i]
    largest, far = w.max(), max(np.abs(q).max(), 1.0)
    for i in range(len(w)):
        if w[i] <= 0.0:
            w[i] = largest if largest > 0.0 else 1.0
            for row in range(3 * i, 3 * i + 3):
                W[row, row], q[row] = w[i], 0.0
            q[3 * i] = far
    return InverseContacts(W, W_ca, q, friction, w, G, exact)


def symmetric_root(A: Array, least: float) -> Array:
    """G (n, rank) with A = G Gᵀ, of A (n, n) symmetric positive semidefinite.

    Args:
        A: (n, n).
        least: pivot at which the factorisation ends; negative: at rounding.
    """
    factor, pivots, rank, _ = dpstrf(A, lower=1, tol=least)
    return unpivoted(factor, pivots, rank)


@kernel
def largest_limit(g_lo: Array, g_hi: Array) -> float:
    """The largest finite limit of rows, by its size.

    Args:
        g_lo: (p,) limits.
        g_hi: (p,) limits.
    """
    largest = 0.0
    for i in range(len(g_lo)):
        for limit in (abs(g_lo[i]), abs(g_hi[i])):
            if limit < np.inf:
                largest = max(largest, limit)
    return largest


@kernel
def unpivoted(factor: Array, pivots: Ints, rank: int) -> Array:
    """The lower factor (n, rank) with its rows in their order.

    Args:
        factor: (n, n) of LAPACK, whose upper triangle is not used.
        pivots: (n,) from one.
        rank: columns.
    """
    G = np.zeros((len(pivots), rank))
    for i in range(len(pivots)):
        for j in range(min(i + 1, rank)):
            G[pivots[i] - 1, j] = factor[i, j]
    return G


class EffortPoint(NamedTuple):
    """Efforts with the exact contact forces that they cause.

    Attributes:
        lam: (n_a,) efforts.
        r: (3 m,) contact forces.
        error: of the natural map over all contacts [unit of u].
        slope: (3 m, n_a) dr/dλ on the piece of these.
        objective: f of (I1).
        excess: over the limits (I2) at most, in the unit of their rows.
    """

    lam: Array
    r: Array
    error: float
    slope: Array
    objective: float
    excess: float
