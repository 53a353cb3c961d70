"""What the nodes of a reduced robot are linear in, and how that changes with its coordinates.

Nodes are at q₀ + E β with a constant E. Coordinates are q = (α, θ, d, c, φ): modes, drives, the displacements
of pins of beams and of the centres of frames, and the rotation vectors of frames with rotations R(φ):

    β = (α, sin θ or travel, d, c, 1 − cos θ, R − I),   ∂R = [ω]x R

with the angular velocities ω as unknowns, as in the full robot. The derivatives by the coordinates are affine
in β, which has the sines, cosines and rotations that they need.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from tauten.model.numerics import (
    Array,
    Ints,
    kernel,
    longest,
    moments_at_end,
    positive_part,
    rotations_between,
    turned,
)

# Entries (i, j, k, m, sign) of ∂R_ij/∂ω_k = sign R_mj.
_TURNED = np.array(
    [
        (i, j, k, m, sign)
        for i, k, m, sign in (
            (0, 1, 2, 1), (0, 2, 1, -1), (1, 2, 0, 1), (1, 0, 2, -1), (2, 0, 1, 1), (2, 1, 0, -1),
        )
        for j in range(3)
    ]
)  # fmt: skip
# [φ]x, row by row, is φ times this.
_CROSS = np.array(
    [[0, 0, 0, 0, 0, -1, 0, 1, 0], [0, 0, 1, 0, 0, 0, -1, 0, 0], [0, -1, 0, 1, 0, 0, 0, 0, 0]]
).astype(float)


@dataclass(frozen=True, slots=True, eq=False)
class Derivative:
    """A derivative J (R, n) with few entries.

    Attributes:
        size: R.
        n: n.
        row: (e,) of each entry.
        column: (e,) of each entry.
        value: (e,) of each entry.
    """

    size: int
    n: int
    row: Ints
    column: Ints
    value: Array

    def rows(self, H: Array) -> Array:
        """H J (m, n) of H (m, R)."""
        product = np.zeros((len(H), self.n))
        multiply(np.ascontiguousarray(H), self.row, self.column, self.value, product)
        return product

    def rates(self, v: Array) -> Array:
        """J v (R,) of v (n,)."""
        return np.bincount(self.row, self.value * v[self.column], self.size).astype(float)

    def forces(self, f: Array) -> Array:
        """Jᵀ f (n,) of f (R,)."""
        return np.bincount(self.column, self.value * f[self.row], self.n).astype(float)

    def congruent(self, K: Array) -> Array:
        """Jᵀ K J (n, n) of a symmetric K (R, R)."""
        half = self.rows(K)  # (R, n)
        return self.rows(half.T)


def still(count: int) -> Array:
    """Unit quaternions (count, 4) of no rotation."""
    found = np.zeros((count, 4))
    found[:, 0] = 1.0
    return found


@kernel
def multiply(H: Array, rows: Ints, columns: Ints, values: Array, product: Array) -> None:
    """Add H J to a product.

    Args:
        H: (m, R).
        rows: (e,) of the entries of J.
        columns: (e,) of the entries of J.
        values: (e,) of the entries of J.
        product: (m, n) added to.
    """
    for i in range(H.shape[0]):
        h, out = H[i], product[i]
        for e in range(rows.shape[0]):
            out[columns[e]] += h[rows[e]] * values[e]


@dataclass(frozen=True, slots=True, eq=False)
class OwnMotion:
    """β and its derivatives by the coordinates.

    Attributes:
        modes: number of α.
        drives: m.
        turning: (t,) numbers of the drives that turn about their axes.
        placed: components of d and c.
        frames: f, those with a rotation.
        reach: (m + f,) largest displacement of a node by a unit of each drive or rotation [m].
        elements: number of the first entries of β that elements depend on.
        pulled: number of those that elements, cables or chambers depend on.
        order: (R,) places in the β above of the entries of β here; None: the same.
        is_plain: whether β are the modes.
        entries: rows and columns of the entries of J, and
        values: places (e,) in β, factors (e,) and constants (e,) that give them: constant + factor β[place].
    """

    modes: int
    drives: int
    turning: Ints
    placed: int
    frames: int
    reach: Array
    elements: int
    pulled: int
    order: Ints | None = None
    is_plain: bool = field(init=False)
    entries: tuple[Ints, Ints] = field(init=False)
    values: tuple[Ints, Array, Array] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "is_plain", self.drives == 0 and self.frames == 0)
        object.__setattr__(self, "entries", self._entries())
        object.__setattr__(self, "values", self._values())

    def _values(self) -> tuple[Ints, Array, Array]:
        """`values`, in the order of `entries`."""
        n, columns = self.straight, self.modes + self.turning
        place, factor, constant = np.zeros(n, np.int64), np.zeros(n), np.ones(n)
        place[columns], factor[columns] = n + np.arange(len(columns)), -1.0  # cos θ
        _, j, _, m, sign = _TURNED.T  # sign R_mj
        frames, first = np.arange(self.frames)[:, None], n + len(columns)
        turned = (first + 9 * frames + 3 * m + j).ravel()
        place = np.concatenate([place, columns, turned])
        factor = np.concatenate([factor, np.ones(len(columns)), np.tile(sign, self.frames)])
        fixed = np.tile(np.where(m == j, sign, 0.0), self.frames)
        constant = np.concatenate([constant, np.zeros(len(columns)), fixed])
        return place if self.order is None else np.argsort(self.order)[place], factor, constant

    def _entries(self) -> tuple[Ints, Ints]:
        """`entries`: of what is straight, of 1 − cos θ, and of rotations."""
        straight, first = np.arange(self.straight), self.straight + len(self.turning)
        i, j, k, _, _ = _TURNED.T
        frame = np.arange(self.frames)[:, None]
        rows = [straight, np.arange(self.straight, first), (first + 9 * frame + 3 * i + j).ravel()]
        turns = (self.straight + 3 * frame + k).ravel()
        row, column = np.concatenate(rows), [straight, self.modes + self.turning, turns]
        if self.order is not None:
            row = np.argsort(self.order)[row]
        return row, np.concatenate(column)

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return self.straight + 3 * self.frames

    @property
    def straight(self) -> int:
        """Number of coordinates that are no rotation vectors."""
        return self.modes + self.drives + self.placed

    @property
    def size(self) -> int:
        """Length of β."""
        return self.straight + len(self.turning) + 9 * self.frames

    def rotations(self, q: Array) -> Array:
        """Rotations R (f, 3, 3) of coordinates (n,)."""
        phi = q[self.straight :].reshape(-1, 3)
        half = np.maximum(0.5 * np.sqrt((phi * phi).sum(axis=1)), 1e-8)  # of the angles
        sine = np.sin(half) / half
        a, b = (sine * np.cos(half))[:, None, None], (0.5 * sine * sine)[:, None, None]
        cross = (phi @ _CROSS).reshape(-1, 3, 3)
        found: Array = np.eye(3) + a * cross + b * (cross @ cross)
        return found

    def beta(self, q: Array) -> Array:
        """β (R, …) of coordinates q (n, …), one state or several in columns."""
        theta = q[self.modes + self.turning]
        parts = [q[: self.straight], 1.0 - np.cos(theta)]
        if self.frames > 0:
            states = q.reshape(self.n, -1).T  # (s, n)
            changes = [self.rotations(one) - np.eye(3) for one in states]
            parts.append(np.stack(changes, axis=-1).reshape(-1, *q.shape[1:]))
        beta = np.concatenate(parts)
        beta[self.modes + self.turning] = np.sin(theta)
        return beta if self.order is None else beta[self.order]

    def jacobian(self, beta: Array) -> Derivative:
        """J = ∂β/∂q (R, n) where β is (R,)."""
        place, factor, constant = self.values
        return Derivative(self.size, self.n, *self.entries, constant + factor * beta[place])

    def turned(self, beta: Array) -> tuple[Array, Array, Array]:
        """Sines (t,) and cosines (t,) of drives that turn, and rotations (f, 3, 3) of frames, of β (R,)."""
        b, first = self.in_order(beta), self.straight + len(self.turning)
        rotations = np.eye(3) + b[first:].reshape(-1, 3, 3)
        return b[self.modes + self.turning], 1.0 - b[self.straight : first], rotations

    def in_order(self, beta: Array) -> Array:
        """An array over β (R,) in the order above."""
        if self.order is None:
            return beta
        found = np.empty_like(beta)
        found[self.order] = beta
        return found

    def centripetal(self, beta: Array, v: Array) -> Array:
        """Accelerations of β (R,) at constant velocities (n,)."""
        columns, (sine, cosine, rotations) = self.modes + self.turning, self.turned(beta)
        square, rate = v[columns] ** 2, np.zeros(self.size)
        rate[columns] = -square * sine
        first = self.straight + len(self.turning)
        rate[self.straight : first] = square * cosine
        if self.frames > 0:
            omega = v[self.straight :].reshape(-1, 3)
            squares = (omega**2).sum(axis=1)[:, None, None] * np.eye(3)
            spun = omega[:, :, None] * omega[:, None, :] - squares  # [ω]x²
            rate[first:] = (spun @ rotations).ravel()
        return rate if self.order is None else rate[self.order]

    def add_curvature(self, beta: Array, force: Array, share: float, K: Array, exact: bool) -> None:
        """Add a share of −Σ f ∂²β/∂q² to a tangent; of rotations the symmetric part.

        Args:
            beta: (R,) where to evaluate.
            force: (R,) f for β.
            share: of it.
            K: (n, n), added to.
            exact: whether all of it is added, or only what is positive semidefinite.
        """
        columns, f = self.modes + self.turning, self.in_order(force)
        first, (sine, cosine, rotations) = self.straight + len(self.turning), self.turned(beta)
        drives = f[columns] * sine - f[self.straight : first] * cosine
        N = rotations @ f[first:].reshape(-1, 3, 3).swapaxes(1, 2)  # (f, 3, 3)
        trace = np.trace(N, axis1=1, axis2=2)
        blocks = trace[:, None, None] * np.eye(3) - 0.5 * (N + N.swapaxes(1, 2))
        if not exact:
            drives, blocks = np.maximum(drives, 0.0), positive_part(blocks)
        rows = self.straight + np.arange(3 * self.frames).reshape(-1, 3)
        K[columns, columns] += share * drives
        K[rows[:, :, None], rows[:, None, :]] += share * blocks

    def moved(self, q: Array, step: Array) -> Array:
        """Coordinates (n,) after a step (n,): velocities times its length."""
        after: Array = q + step
        if self.frames > 0:
            first, none = self.straight, still(self.frames)
            before = turned(none, q[first:].reshape(-1, 3))
            end = turned(before, step[first:].reshape(-1, 3))
            after[first:] = rotations_between(none, end).ravel()
        return after

    def between(self, before: Array, after: Array) -> Array:
        """The step (n,) that moves coordinates (n,) to others (n,), inverse of `moved`; turns of up to π."""
        step: Array = after - before
        if self.frames > 0:
            first, none = self.straight, still(self.frames)
            start, end = (turned(none, one[first:].reshape(-1, 3)) for one in (before, after))
            step[first:] = rotations_between(start, end).ravel()
        return step

    def at_end(self, step: Array, force: Array) -> Array:
        """Forces (n,) at the end of a step (n,) that do the work of given ones (n,) on it [N], [N m]."""
        found = force.copy()
        if self.frames > 0:
            turns, moments = (part[self.straight :].reshape(-1, 3) for part in (step, force))
            found[self.straight :] = moments_at_end(turns, moments).ravel()
        return found

    def largest_move(self, step: Array) -> float:
        """Largest displacement of a node by drives, pins and frames in a step (n,), about [m]."""
        end = self.modes + self.drives
        turns = np.linalg.norm(step[self.straight :].reshape(-1, 3), axis=1)
        arms = self.reach * np.concatenate([np.abs(step[self.modes : end]), turns])
        placed = longest(step[end : self.straight])
        return float(max(placed, arms.max(initial=0.0)))
