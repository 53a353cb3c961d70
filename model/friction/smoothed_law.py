"""A smoothed law of contact with friction, and how forces follow what pushes the contacts under it.

With w the compliance of a contact, x = w r_n, y = u_n, z = w r_t − u_t and a width k of the contact:

    p = (x − y + sqrt((x − y)² + 4 (κ k)²)) / 2,   F_n = x − p,
    s = (|z| + μ p + sqrt((|z| − μ p)² + 4 (κ k)²)) / 2,   F_t = w r_t − μ p z / s              (F2)

F = 0 is contact with friction where κ = 0: p is the larger one of x − y and zero, and μ p z / s the
projection of z on the disc of radius μ p. x y = (κ k)² is the central path of the normal law. Where the
exact law holds, |F| is at most (1 + μ) κ k, also of contacts that are between two pieces: so a path
leaves exact forces with full steps. Friction is that of p rather than of x, so that forces on the way to
a solution may have any sign.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tauten.model.friction.problem import Cones, velocities
from tauten.model.numerics import Array, Ints, kernel, solve_linear

FAR = 1e-3  # w B⁻¹ A of a contact, below which others do not change its force


class Widths(NamedTuple):
    """Widths of the smoothed law.

    Attributes:
        share: κ.
        each: (m,) k of each contact.
    """

    share: float
    each: Array


@kernel
def widths(W_ii: Array, r: Array, share: float, length: float) -> Widths:
    """Widths of the law at given forces, one scale of force for all contacts.

    A scale for each would hide a contact that carries little beside one that carries the weight.

    Args:
        W_ii: (m,) largest compliance of each contact, along its normal or across it.
        r: (3 m,) forces.
        share: κ.
        length: displacement that matters.
    """
    largest = max(r[::3].max(), 0.0)
    return Widths(share, np.sqrt(length * np.maximum(length, W_ii * largest)))


@kernel
def law_error(width: Widths, F: Array) -> float:
    """Largest |F| (m, 3), along or across the normal, relative to the width of the contact."""
    largest = 0.0
    for i in range(len(F)):
        across = np.sqrt(F[i, 1] * F[i, 1] + F[i, 2] * F[i, 2])
        error = np.maximum(abs(F[i, 0]), across)
        largest = np.maximum(largest, error / (width.share * width.each[i]))
    return largest


@kernel
def law_size(width: Widths, F: Array) -> float:
    """|F| (m, 3) with contacts weighed by their widths: what line searches reduce."""
    total = 0.0
    for i in range(len(F)):
        for j in range(3):
            total += (F[i, j] / width.each[i]) ** 2
    return float(np.sqrt(total))


class LinearLaw(NamedTuple):
    """The smoothed law linearised: dr = residual + slope dλ meets it in the first order.

    Attributes:
        u: (m, 3) displacements.
        F: (m, 3) of (F2).
        residual: (3 m,).
        slope: (3 m, n_a).
    """

    u: Array
    F: Array
    residual: Array
    slope: Array


class DiscProjection(NamedTuple):
    """The smoothed projection z ↦ μ p z / s of one contact, and its derivatives.

    Attributes:
        share: μ p / s.
        rest: one less that share.
        along: ∂ |μ p z / s| / ∂ |z|.
        rest_along: one less that.
        growth: ∂ (μ p |z| / s) / ∂ (μ p).
    """

    share: float
    rest: float
    along: float
    rest_along: float
    growth: float


@kernel
def smoothed_disc(length: float, radius: float, k: float) -> DiscProjection:
    """The smoothed projection on a disc.

    Args:
        length: |z|.
        radius: μ p, positive.
        k: width of the law at the contact, κ k.
    """
    beyond = length - radius
    root = np.sqrt(beyond * beyond + 4.0 * k * k)
    # s − μ p without cancellation where the contact sticks
    left = 0.5 * (root + beyond) if beyond > 0.0 else 2.0 * k * k / (root - beyond)
    s, s_length = radius + left, 0.5 * (1.0 + beyond / root)
    share, rest, bent = radius / s, left / s, length * s_length / s
    growth = length * (left + radius * s_length) / (s * s)
    return DiscProjection(share, rest, share * (1.0 - bent), rest + share * bent, growth)


@kernel
def smoothed_law(cones: Cones, u: Array, r: Array, width: Widths) -> Array:
    """F (m, 3) of (F2).

    Args:
        cones: the contacts.
        u: (m, 3) displacements.
        r: (3 m,) forces.
        width: of the law.
    """
    w, mu, F = cones.W_ii, cones.mu, np.empty(u.shape)
    for i in range(len(w)):
        x, x_1, x_2 = w[i] * r[3 * i], w[i] * r[3 * i + 1], w[i] * r[3 * i + 2]
        open_, k = u[i, 0] - x, width.share * width.each[i]
        pushed = 0.5 * (np.sqrt(open_ * open_ + 4.0 * k * k) - open_)
        z_1, z_2 = x_1 - u[i, 1], x_2 - u[i, 2]
        length, radius = np.sqrt(z_1 * z_1 + z_2 * z_2), mu[i] * pushed
        beyond = length - radius
        share = 2.0 * radius / (length + radius + np.sqrt(beyond * beyond + 4.0 * k * k))
        F[i, 0], F[i, 1], F[i, 2] = x - pushed, x_1 - share * z_1, x_2 - share * z_2
    return F


@kernel
def linear_law(cones: Cones, G: Array, r: Array, width: Widths, W_ca: Array) -> LinearLaw:
    """Linearise (F2): one system with 1 + n_a right-hand sides.

    With A = ∂F/∂u and B = ∂F/∂r, which has an inverse, dr = −B⁻¹ (F + A (W dr + W_ca dλ)). Of contacts
    far from touching B⁻¹ A is next to nothing, and they get −B⁻¹ F. For the others it is a system in
    their forces or, where W = G Gᵀ has a lower rank than these have rows, the state form in y = Gᵀ dr.

    Args:
        cones: the contacts.
        G: (3 m, rank) of the state form; no columns: the system is that of the forces.
        r: (3 m,) forces.
        width: of the law.
        W_ca: (3 m, n_a) how efforts move the contacts; no columns where no slope is asked for.
    """
    n_a, rank, u = W_ca.shape[1], G.shape[1], velocities(cones, r)
    F = smoothed_law(cones, u, r, width)
    alone, blocks = law_blocks(cones, u, r, width, F)
    near = np.flatnonzero(cones.W_ii * blocks[:, 0, 0] > FAR)
    rows = three_rows(near)
    residual, slope = -alone, np.zeros((len(r), n_a))
    others, C = residual.copy(), blocks[near]
    others[rows] = 0.0
    pushed = np.empty((len(rows), 1 + n_a))  # displacements by other contacts, and by efforts
    pushed[:, 1:] = W_ca[rows]
    if 0 < rank < len(rows):
        root = G[rows]
        pushed[:, 0] = np.dot(root, np.dot(G.T, others))
        known, moved = through_blocks(C, pushed), through_blocks(C, root)
        known[:, 0] += alone[rows]
        solved, y = solve_linear(with_unit(np.dot(root.T, moved)), np.dot(root.T, known))
        change = np.dot(moved, y) - known
    else:
        W = np.empty((len(rows), len(rows)))
        for i, row in enumerate(rows):
            pushed[i, 0] = np.dot(cones.W[row], others)
            for k, column in enumerate(rows):
                W[i, k] = cones.W[row, column]
        known = through_blocks(C, pushed)
        known[:, 0] += alone[rows]
        solved, y = solve_linear(with_unit(through_blocks(C, W)), known)
        change = -y
    if not solved:
        change[:] = np.nan
    residual[rows], slope[rows] = change[:, 0], change[:, 1:]
    return LinearLaw(u, F, residual, slope)


@kernel
def three_rows(contacts: Ints) -> Ints:
    """The rows (3 s,) of some contacts (s,)."""
    rows = np.empty(3 * len(contacts), np.int64)
    for i, contact in enumerate(contacts):
        for j in range(3):
            rows[3 * i + j] = 3 * contact + j
    return rows


@kernel
def with_unit(A: Array) -> Array:
    """A (n, n) and the unit matrix, in place."""
    for i in range(len(A)):
        A[i, i] += 1.0
    return A


@kernel
def law_blocks(cones: Cones, u: Array, r: Array, width: Widths, F: Array) -> tuple[Array, Array]:
    """B⁻¹ F (3 m,) and the blocks B⁻¹ A (m, 3, 3) of (F2); they have no entries (0, 1) and (0, 2).

    Args:
        cones: the contacts.
        u: (m, 3) displacements.
        r: (3 m,) forces.
        width: of the law.
        F: (m, 3) of (F2).
    """
    w, mu = cones.W_ii, cones.mu
    first, blocks = np.empty(len(r)), np.zeros((len(w), 3, 3))
    for i in range(len(w)):
        row, k, yields = 3 * i, width.share * width.each[i], 1.0 / w[i]
        z = w[i] * r[row] - u[i, 0]
        root = z * z + 4.0 * k * k
        s = z / np.sqrt(root)
        # 1 − s without cancellation where the contact is closed
        away = 1.0 - s if s < 0.9 else 4.0 * k * k / (root * (1.0 + s))
        z_1, z_2 = w[i] * r[row + 1] - u[i, 1], w[i] * r[row + 2] - u[i, 2]
        length = np.sqrt(z_1 * z_1 + z_2 * z_2)
        e_1, e_2 = (z_1 / length, z_2 / length) if length > 0.0 else (1.0, 0.0)
        disc = smoothed_disc(length, mu[i] * (w[i] * r[row] - F[i, 0]), k)
        # where F_n is met to first order p is x: friction is that of x + dx
        h = mu[i] * disc.growth / disc.rest_along
        ratio = (1.0 + s) * yields / away
        first[row] = 2.0 * F[i, 0] * yields / away
        along = (e_1 * F[i, 1] + e_2 * F[i, 2]) / disc.rest_along - h * F[i, 0]
        along = along * yields + h * first[row]
        across = (e_1 * F[i, 2] - e_2 * F[i, 1]) / disc.rest * yields
        first[row + 1], first[row + 2] = along * e_1 - across * e_2, along * e_2 + across * e_1
        blocks[i, 0, 0] = ratio
        blocks[i, 1, 0], blocks[i, 2, 0] = h * e_1 * ratio, h * e_2 * ratio
        t_along, t_across = disc.along / disc.rest_along * yields, disc.share / disc.rest * yields
        blocks[i, 1, 1] = t_along * e_1 * e_1 + t_across * e_2 * e_2
        blocks[i, 2, 2] = t_along * e_2 * e_2 + t_across * e_1 * e_1
        blocks[i, 1, 2] = blocks[i, 2, 1] = (t_along - t_across) * e_1 * e_2
    return first, blocks


@kernel
def through_blocks(blocks: Array, X: Array) -> Array:
    """Blocks (m, 3, 3) of `law_blocks` times X (3 m, n)."""
    Y = np.empty(X.shape)
    for i in range(len(blocks)):
        row, C = 3 * i, blocks[i]
        for j in range(X.shape[1]):
            n, t_1, t_2 = X[row, j], X[row + 1, j], X[row + 2, j]
            Y[row, j] = C[0, 0] * n
            Y[row + 1, j] = C[1, 0] * n + C[1, 1] * t_1 + C[1, 2] * t_2
            Y[row + 2, j] = C[2, 0] * n + C[2, 1] * t_1 + C[2, 2] * t_2
    return Y
