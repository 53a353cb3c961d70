"""Kernels of a robot in reduced coordinates q = q₀ + Φ α: no array here is as long as the mesh.

**Elements** (`tauten.reduction.state.tetra.elements`) and **cables** contribute rows, the columns of Z
(r, z), with their images in Y (r, z), so that one matrix product Z Yᵀ is the tangent. A cable segment's
difference of stations is d = d₀ + D α; its tension adds λ Dᵀ (I − d dᵀ/ℓ²) D / ℓ. Lengths of short segments
are rounded as in `tauten.model.points.cable`.
"""

from __future__ import annotations

import numpy as np

from tauten.model.numerics import Array, Ints, kernel
from tauten.model.points import blunted
from tauten.reduction.dense_step import Scheme, implicit_step
from tauten.reduction.state.tetra.arrays import Body, Tendons, Work
from tauten.reduction.state.tetra.elements import assemble_elements
from tauten.reduction.state.tetra.product import symmetric_product


@kernel
def assemble_sample(
    alpha: Array, effort: Array, load: Array, exact: bool, body: Body, tendons: Tendons, work: Work
) -> None:
    """Force without actuators and contacts and the tangent, into work.force and work.K.

    Args:
        alpha: (r,) [m].
        effort: (n_a,) [N], for the curvature of the cables.
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
    position = effort if exact else np.maximum(effort, 0.0)  # rods that push soften
    add_curvature(alpha, position, tendons, first, work.Y)
    symmetric_product(work.Z, work.Y, work.lower)
    for i in range(alpha.shape[0]):
        for j in range(i + 1):
            work.K[i, j] = work.K[j, i] = work.lower[i, j]
    work.K[:] += body.stiffness
    if exact:
        work.K[:] += work.curvature


@kernel
def add_curvature(alpha: Array, effort: Array, tendons: Tendons, first: int, Y: Array) -> None:
    """Images of the rows D of the segments.

    Args:
        alpha: (r,) state [m].
        effort: (n_a,) cable tensions [N].
        tendons: the cables.
        first: their first column of Y.
        Y: (r, z) output.
    """
    d = tendons.rest + np.dot(alpha, tendons.map)
    g = d.shape[0] // 3
    x, y, z, scale, along = d[:g], d[g : 2 * g], d[2 * g :], np.zeros(g), np.zeros(g)
    for a in range(effort.shape[0]):
        for s in range(tendons.starts[a], tendons.starts[a + 1]):
            square = x[s] * x[s] + y[s] * y[s] + z[s] * z[s]
            _, slope, curvature = blunted(np.sqrt(square), tendons.shortest[s])
            scale[s] = effort[a] * slope
            if square > 0.0:
                along[s] = effort[a] * (slope - curvature) / square
    for j in range(alpha.shape[0]):
        D, out = tendons.map[j], Y[j, first : first + 3 * g]
        for s in range(g):
            D0, D1, D2 = D[s], D[g + s], D[2 * g + s]
            dot = along[s] * (x[s] * D0 + y[s] * D1 + z[s] * D2)
            out[s], out[g + s] = scale[s] * D0 - dot * x[s], scale[s] * D1 - dot * y[s]
            out[2 * g + s] = scale[s] * D2 - dot * z[s]


@kernel
def linearise(
    alpha: Array, v: Array, effort: Array, load: Array, dynamics: tuple[Array, Scheme],
    body: Body, tendons: Tendons, work: Work,
) -> tuple[float, bool]:  # fmt: skip
    """Factors of A into work.L and v_free into work.v_free, see `implicit_step`.

    Args:
        alpha: (r,) state [m].
        v: (r,) its rate [m/s].
        effort: as in `assemble_sample`.
        load: as in `assemble_sample`.
        dynamics: mass (r, r) [kg], and the scheme.
        body: the elements.
        tendons: the cables.
        work: overwritten.

    Returns:
        Norm of the forces out of balance [N], NaN when A is not positive definite; whether A has the exact
        tangent.
    """
    mass, scheme = dynamics
    if not scheme.static and scheme.b_K > 0.0:
        assemble_sample(alpha, np.zeros_like(effort), load, False, body, tendons, work)
        work.D[:] = work.K
    for exact in (True, False):  # buckling makes the exact tangent indefinite
        assemble_sample(alpha, effort, load, exact, body, tendons, work)
        if implicit_step(scheme, mass, work.D, work.K, work.force, v, work.L, work.v_free):
            return float(np.sqrt(np.dot(work.force, work.force))), exact
    return np.nan, False


@kernel
def contact_jacobian(
    normal: Array, slots: Ints, vertices: Ints, coefficients: Array, own: Array, surface: Array
) -> Array:
    """Contact rows in reduced coordinates (m, r), equation (T2) of `tauten.model.contact.detection`.

    Args:
        normal: (m, 3) directions.
        slots: (m,) candidates.
        vertices: (m, 6) vertices of each row; the first three are those of the candidate, and not used.
        coefficients: (m, 6) their shares.
        own: (n_c, 3, r) derivative of the candidates with respect to α.
        surface: (3 v, r) that of the vertices.
    """
    m, r = normal.shape[0], surface.shape[1]
    H = np.empty((m, r))
    for k in range(m):
        n0, n1, n2 = normal[k, 0], normal[k, 1], normal[k, 2]
        h, x, y, z = H[k], own[slots[k], 0], own[slots[k], 1], own[slots[k], 2]
        for j in range(r):
            h[j] = n0 * x[j] + n1 * y[j] + n2 * z[j]
        # one vertex at a time: the compiler makes vector instructions of short sums only
        for a in range(3, 6):
            w, f = coefficients[k, a], 3 * vertices[k, a]
            w0, w1, w2 = w * n0, w * n1, w * n2
            x, y, z = surface[f], surface[f + 1], surface[f + 2]
            for j in range(r):
                h[j] += w0 * x[j] + w1 * y[j] + w2 * z[j]
    return H
