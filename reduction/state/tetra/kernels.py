"""Kernels of a robot in reduced coordinates q = q₀ + Φ α: no array here is as long as the mesh.

**Elements** (`tauten.reduction.state.tetra.elements`) and **cables** contribute rows, the columns of Z
(r, z), with their images in Y (r, z), so that the product Z Yᵀ is a tangent. It is summed over blocks of
elements, whose rows fit into the processor's cache. A system needs a sum h b_K D + h² K of the stiffness of
the material and the tangent: their images are added, so that it costs one product. Systems of several lengths
at one state need other sums: D and K have a product each, which corotational elements make in one pass.

A cable segment's difference of stations is d = d₀ + D α; its tension adds λ Dᵀ (I − d dᵀ/ℓ²) D / ℓ. Lengths
of short segments are rounded as in `tauten.model.points.cable`.
"""

from __future__ import annotations

import numpy as np

from tauten.model.numerics import LANES, Array, kernel
from tauten.model.points import blunted
from tauten.reduction.state.tetra.arrays import Response, SampledElements, Tendons, Work
from tauten.reduction.state.tetra.elements import add_elements, project
from tauten.reduction.state.tetra.product import add_symmetric_product


@kernel
def combine(
    alpha: Array, effort: Array, shares: tuple[float, float], exact: bool, response: Response,
    body: SampledElements, tendons: Tendons, work: Work,
) -> None:  # fmt: skip
    """A sum of the stiffness of the material D and the tangent K into work.S.

    Args:
        alpha: (r,) state [m]; elements depend on the first of its entries.
        effort: (n_a,) cable tensions, for their curvature [N].
        shares: of D and of K.
        exact: whether K is the derivative, or positive semidefinite.
        response: of the elements and chambers at the state.
        body: the elements.
        tendons: the cables.
        work: overwritten.
    """
    of_D, of_K = shares
    work.lower[:] = 0.0
    add_elements(shares, exact, response, body, work)
    if tendons.map.shape[1] > 0:
        pulling = effort if exact else np.maximum(effort, 0.0)  # rods that push soften
        curve(alpha, of_K * pulling, tendons, work.segments)
        add_symmetric_product(tendons.map, work.segments, work.lower)
    for i in range(alpha.shape[0]):
        for j in range(i + 1):
            work.S[i, j] = work.S[j, i] = work.lower[i, j]
    if body.corotational:
        r = body.stiffness.shape[0]
        work.S[:r, :r] += (of_D + of_K) * body.stiffness
    if exact:
        work.S[:] += of_K * response.curvature


@kernel
def tangents_apart(
    alpha: Array, effort: Array, response: Response, body: SampledElements, tendons: Tendons,
    work: Work,
) -> tuple[Array, Array]:  # fmt: skip
    """The stiffness of the material D of elements and the derivative K of all: (k, k) each.

    Args:
        alpha: (k,) state [m]; elements depend on the first of its entries.
        effort: (n_a,) cable tensions, for their curvature [N].
        response: of the elements and chambers at the state.
        body: the elements.
        tendons: the cables.
        work: overwritten.
    """
    if not body.corotational:
        combine(alpha, effort, (1.0, 0.0), True, response, body, tendons, work)
        D = work.S.copy()
        combine(alpha, effort, (0.0, 1.0), True, response, body, tendons, work)
        return D, work.S.copy()
    n, r = alpha.shape[0], body.stiffness.shape[0]
    work.lower[:] = 0.0
    more = np.zeros(work.lower.shape)  # of D than of K
    for block in range(body.gradient.shape[0]):
        lame, carried = body.lame[block], response.carried[block]
        project(r, body.gradient[block], carried, response.exact[block], lame, work)
        add_symmetric_product(work.Z, work.Y, work.lower)
        for j in range(r):  # images of t and a with the rotation held, less those of K
            z, y = work.Z[j], work.Y[j]
            for k in range(LANES):
                a, b, c, mu = LANES + k, 2 * LANES + k, 3 * LANES + k, lame[LANES + k]
                y[k], y[a] = 0.0, -mu * z[a] - y[a]
                y[b], y[c] = -mu * z[b] - y[b], -mu * z[c] - y[c]
        add_symmetric_product(work.Z, work.Y, more)
    D, K = np.zeros((n, n)), np.zeros((n, n))
    for i in range(r):
        for j in range(i + 1):
            D[i, j] = D[j, i] = work.lower[i, j] + more[i, j]
    if tendons.map.shape[1] > 0:
        curve(alpha, effort, tendons, work.segments)
        add_symmetric_product(tendons.map, work.segments, work.lower)
    for i in range(n):
        for j in range(i + 1):
            K[i, j] = K[j, i] = work.lower[i, j]
    D[:r, :r] += body.stiffness
    K[:r, :r] += body.stiffness
    K[:] += response.curvature
    return D, K


@kernel
def curve(alpha: Array, effort: Array, tendons: Tendons, Y: Array) -> None:
    """Images of the rows D of the segments.

    Args:
        alpha: (r,) state [m].
        effort: (n_a,) cable tensions, or multiples of them [N].
        tendons: the cables.
        Y: (R, 3 g) output, rows below r.
    """
    d = tendons.rest + np.dot(alpha, tendons.map[: alpha.shape[0]])
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
        D, out = tendons.map[j], Y[j]
        for s in range(g):
            D0, D1, D2 = D[s], D[g + s], D[2 * g + s]
            dot = along[s] * (x[s] * D0 + y[s] * D1 + z[s] * D2)
            out[s], out[g + s] = scale[s] * D0 - dot * x[s], scale[s] * D1 - dot * y[s]
            out[2 * g + s] = scale[s] * D2 - dot * z[s]
