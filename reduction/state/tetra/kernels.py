"""Kernels of a robot in reduced coordinates q = q₀ + Φ α: no array here is as long as the mesh.

**Elements** (`tauten.reduction.state.tetra.elements`) and **cables** contribute rows that stand below each
other in Z (z, r), with their images in Y (z, r), so that one matrix product Zᵀ Y is the tangent. A cable
segment's difference of stations is d = d₀ + D α; its tension adds λ Dᵀ (I − d dᵀ/ℓ²) D / ℓ.
"""

from __future__ import annotations

import numpy as np

from tauten.model.numerics import Array, Ints, kernel
from tauten.reduction.dense_step import Scheme, implicit_step
from tauten.reduction.state.tetra.arrays import COLUMNS, ROWS, Body, Tendons, Work
from tauten.reduction.state.tetra.elements import assemble_elements


@kernel
def assemble_sample(
    alpha: Array, tension: Array, load: Array, exact: bool, body: Body, tendons: Tendons, work: Work
) -> None:
    """Force without actuators and contacts and the tangent, into work.force and work.K.

    Args:
        alpha: (r,) [m].
        tension: (n_a,) [N], for the curvature of the cables.
        load: (r,) Φᵀ of gravity and outer forces [N].
        exact: whether the tangent includes the change of rotations.
        body: the elements.
        tendons: the cables.
        work: overwritten.
    """
    np.dot(body.stiffness, alpha, work.force)
    for j in range(alpha.shape[0]):
        work.force[j] = load[j] - body.drift[j] - work.force[j]
    first = assemble_elements(alpha, exact, body, work)
    add_curvature(alpha, tension, tendons, first, work)
    symmetric_product(work.Z, work.Y, work.lower, work.K)
    work.K[:] += body.stiffness
    if exact:
        work.K[:] += work.curvature


@kernel
def symmetric_product(Z: Array, Y: Array, lower: Array, K: Array) -> None:
    """K = Zᵀ Y, where that is symmetric: half the operations of a general product.

    A pair of rows of K is updated by ROWS rows of Z and Y at a time, over whole vectors of COLUMNS numbers.

    Args:
        Z: (z, n) with zeros up to a multiple of ROWS rows and of COLUMNS columns.
        Y: (z, n) likewise.
        lower: (n, n) overwritten.
        K: (r, r) output, r ≤ n.
    """
    lower[:] = 0.0
    for k in range(0, Z.shape[0], ROWS):
        for i in range(0, lower.shape[0], 2):
            z0, z1, z2, z3 = Z[k, i], Z[k + 1, i], Z[k + 2, i], Z[k + 3, i]
            w0, w1, w2, w3 = Z[k, i + 1], Z[k + 1, i + 1], Z[k + 2, i + 1], Z[k + 3, i + 1]
            for j in range(COLUMNS * (i // COLUMNS + 1)):
                y0, y1, y2, y3 = Y[k, j], Y[k + 1, j], Y[k + 2, j], Y[k + 3, j]
                lower[i, j] += z0 * y0 + z1 * y1 + z2 * y2 + z3 * y3
                lower[i + 1, j] += w0 * y0 + w1 * y1 + w2 * y2 + w3 * y3
    for i in range(K.shape[0]):
        for j in range(i + 1):
            K[i, j] = lower[i, j]
            K[j, i] = lower[i, j]


@kernel
def add_curvature(alpha: Array, tension: Array, tendons: Tendons, first: int, work: Work) -> None:
    """Rows D of the segments and their images, from row `first` of Z and Y on.

    Args:
        alpha: (r,) state [m].
        tension: (n_a,) cable tensions [N].
        tendons: the cables.
        first: row of Z and Y to start at.
        work: Z, Y and d are written.
    """
    np.dot(tendons.map, alpha, work.d)
    D, Z, Y = tendons.map, work.Z, work.Y
    for s in range(tendons.owner.shape[0]):
        k, z = 3 * s, first + 3 * s
        d0 = tendons.rest[k] + work.d[k]
        d1 = tendons.rest[k + 1] + work.d[k + 1]
        d2 = tendons.rest[k + 2] + work.d[k + 2]
        square = d0 * d0 + d1 * d1 + d2 * d2
        pull = max(tension[tendons.owner[s]], 0.0)
        scale = pull / np.sqrt(square) if square > 0.0 else 0.0
        along = scale / square if square > 0.0 else 0.0
        for j in range(D.shape[1]):
            D0, D1, D2 = D[k, j], D[k + 1, j], D[k + 2, j]
            dot = along * (d0 * D0 + d1 * D1 + d2 * D2)
            Z[z, j], Z[z + 1, j], Z[z + 2, j] = D0, D1, D2
            Y[z, j] = scale * D0 - dot * d0
            Y[z + 1, j] = scale * D1 - dot * d1
            Y[z + 2, j] = scale * D2 - dot * d2


@kernel
def pulled_lengths(alpha: Array, tendons: Tendons) -> tuple[Array, Array]:
    """Pulled lengths L(q₀) − L(q) (n_a,) [m] and their rows −∂L/∂α (n_a, r)."""
    r, n_a = alpha.shape[0], tendons.rest_length.shape[0]
    H, delta = np.zeros((n_a, r)), tendons.rest_length.copy()
    d, D = tendons.rest + np.dot(tendons.map, alpha), tendons.map
    for s in range(tendons.owner.shape[0]):
        k, a = 3 * s, tendons.owner[s]
        length = np.sqrt(d[k] * d[k] + d[k + 1] * d[k + 1] + d[k + 2] * d[k + 2])
        delta[a] -= length
        if length > 0.0:
            u0, u1, u2 = d[k] / length, d[k + 1] / length, d[k + 2] / length
            for j in range(r):
                H[a, j] -= u0 * D[k, j] + u1 * D[k + 1, j] + u2 * D[k + 2, j]
    return H, delta


@kernel
def linearise(
    alpha: Array, v: Array, tension: Array, load: Array, dynamics: tuple[Array, Scheme],
    body: Body, tendons: Tendons, work: Work,
) -> float:  # fmt: skip
    """Factors of A into work.L and v_free into work.v_free, see `implicit_step`.

    Args:
        alpha: (r,) state [m].
        v: (r,) its rate [m/s].
        tension: as in `assemble_sample`.
        load: as in `assemble_sample`.
        dynamics: mass (r, r) [kg], and the scheme.
        body: the elements.
        tendons: the cables.
        work: overwritten.

    Returns:
        Norm of the forces out of balance [N]; NaN when A is not positive definite.
    """
    mass, scheme = dynamics
    for exact in (True, False):  # buckling makes the exact tangent indefinite
        assemble_sample(alpha, tension, load, exact, body, tendons, work)
        if implicit_step(scheme, mass, work.K, work.force, v, work.L, work.v_free):
            return float(np.sqrt(np.dot(work.force, work.force)))
    return np.nan


@kernel
def contact_jacobian(normal: Array, vertices: Ints, coefficients: Array, surface: Array) -> Array:
    """Contact rows in reduced coordinates (m, r), equation (T2) of `tauten.model.contact.detection`.

    Args:
        normal: (m, 3) directions.
        vertices: (m, 6) vertices of each row.
        coefficients: (m, 6) their shares.
        surface: (3 v, r) derivative of the vertices with respect to α.
    """
    m, r = normal.shape[0], surface.shape[1]
    H = np.zeros((m, r))
    for k in range(m):
        n0, n1, n2 = normal[k, 0], normal[k, 1], normal[k, 2]
        # two at a time: the compiler makes vector instructions of short sums only
        for a in range(0, 6, 2):
            v, w = coefficients[k, a], coefficients[k, a + 1]
            f, s = 3 * vertices[k, a], 3 * vertices[k, a + 1]
            v0, v1, v2, w0, w1, w2 = v * n0, v * n1, v * n2, w * n0, w * n1, w * n2
            for j in range(r):
                change = v0 * surface[f, j] + v1 * surface[f + 1, j] + v2 * surface[f + 2, j]
                change += w0 * surface[s, j] + w1 * surface[s + 1, j] + w2 * surface[s + 2, j]
                H[k, j] += change
    return H
