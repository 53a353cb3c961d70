"""Kernels of a robot in reduced coordinates q = q₀ + Φ α: no array here is as long as the mesh.

**Elements.** The stress of a corotational tetrahedron (`tauten.model.tetra.elements`) is P = 2 μ F + c R with
c = λ tr(S − I) − 2 μ, and F = I + G α is linear in α. So its force and its exact tangent are

    f = −V Gᵀ(2 μ (I + G α)) − V c t                   t = Gᵀ R, the gradient of tr S
    K = V (2 μ Gᵀ G + λ t tᵀ + c aᵀ (tr(S) I − S)⁻¹ a)   a: axial vector of Rᵀ dF − (Rᵀ dF)ᵀ

of which only t (r,) and a (3, r) change: all other terms are summed once. With the rotation held
c (tr(S) I − S)⁻¹ is −μ I. Summed over a sample of elements with weights w (`tauten.reduction.state.ecsw`),
V is w V.

**Cables.** A segment's difference of stations is d = d₀ + D α; its tension adds λ Dᵀ (I − d dᵀ/ℓ²) D / ℓ.

Rows t, a and D stand below each other in Z (z, r), their images in Y (z, r), so that one matrix product
Zᵀ Y is the tangent.
"""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np

from tauten.model.numerics import Array, Ints, cholesky, kernel, polar_rotations, solve_in_place

# of a symmetric 3x3 matrix: entries 00, 01, 02, 11, 12, 22
Symmetric: TypeAlias = tuple[float, float, float, float, float, float]


class Body(NamedTuple):
    """Sampled elements; a tuple because kernels accept it directly.

    Attributes:
        gradient: (9 s, r) G, row 9 e + 3 i + j the change of F_ij of element e.
        volume: (s,) weighted volumes w V [m³].
        lame: (λ, μ) [Pa].
        stiffness: (r, r) Σ 2 μ w V GᵀG.
        drift: (r,) Σ 2 μ w V Gᵀ I.
    """

    gradient: Array
    volume: Array
    lame: tuple[float, float]
    stiffness: Array
    drift: Array


class Tendons(NamedTuple):
    """Cable segments; a tuple because kernels accept it directly.

    Attributes:
        owner: (g,) cable of each segment.
        map: (3 g, r) D, change of the difference of its stations.
        rest: (3 g,) d₀ [m].
        rest_length: (n_a,) [m].
    """

    owner: Ints
    map: Array
    rest: Array
    rest_length: Array


class Dynamics(NamedTuple):
    """Mass, damping and time step; a tuple because kernels accept it directly.

    Attributes:
        mass: (r, r) Φᵀ M Φ [kg].
        h: time step [s].
        static: whether inertia and damping are left out.
        a: of the Rayleigh damping a M + b_K K [1/s].
        b_K: of the Rayleigh damping [s].
    """

    mass: Array
    h: float
    static: bool
    a: float
    b_K: float


class Work(NamedTuple):
    """Workspace of the kernels, allocated once.

    Attributes:
        F: (s, 3, 3) deformation gradients.
        R: (s, 3, 3) their rotations.
        d: (3 g,) differences of stations.
        Z, Y: (4 s + 3 g, r) rows and their images.
        force: (r,) [N].
        K: (r, r) tangent [N/m].
        curvature: (r, r) what chambers add to an exact tangent [N/m], set before a call.
        A: (r, r) matrix of the step.
        L: (r, r) its Cholesky factor.
        v_free: (r,) [m/s].
    """

    F: Array
    R: Array
    d: Array
    Z: Array
    Y: Array
    force: Array
    K: Array
    curvature: Array
    A: Array
    L: Array
    v_free: Array


def make_work(body: Body, tendons: Tendons) -> Work:
    """A workspace for these elements and cables."""
    r, z = body.gradient.shape[1], 4 * len(body.volume) + len(tendons.rest)
    return Work(
        F=np.empty((len(body.volume), 3, 3)),
        R=np.empty((len(body.volume), 3, 3)),
        d=np.empty(len(tendons.rest)),
        Z=np.empty((z, r)),
        Y=np.empty((z, r)),
        force=np.empty(r),
        K=np.empty((r, r)),
        curvature=np.zeros((r, r)),
        A=np.empty((r, r)),
        L=np.zeros((r, r)),
        v_free=np.empty(r),
    )


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
    np.dot(body.gradient, alpha, work.F.reshape(-1))
    for i in range(3):
        work.F[:, i, i] += 1.0
    polar_rotations(work.F, work.R)
    for e in range(body.volume.shape[0]):
        c, Q = stress_and_turning(work.F[e], work.R[e], body.lame, exact)
        project(e, body.volume[e], c, work.R[e], Q, body, work)
    add_curvature(alpha, tension, tendons, 4 * body.volume.shape[0], work)
    np.dot(work.Z.T, work.Y, work.K)
    work.K[:] += body.stiffness
    if exact:
        work.K[:] += work.curvature


@kernel
def stress_and_turning(
    F: Array, R: Array, lame: tuple[float, float], exact: bool
) -> tuple[float, Symmetric]:
    """The stress coefficient c, and c (tr(S) I − S)⁻¹, or −μ I with rotations held.

    Args:
        F: (3, 3) deformation gradient.
        R: (3, 3) its rotation.
        lame: (λ, μ) [Pa].
        exact: whether the tangent includes the change of rotations.

    Returns:
        c [Pa]; the six entries of the symmetric matrix [Pa].
    """
    lam, mu = lame
    S00 = R[0, 0] * F[0, 0] + R[1, 0] * F[1, 0] + R[2, 0] * F[2, 0]
    S11 = R[0, 1] * F[0, 1] + R[1, 1] * F[1, 1] + R[2, 1] * F[2, 1]
    S22 = R[0, 2] * F[0, 2] + R[1, 2] * F[1, 2] + R[2, 2] * F[2, 2]
    S01 = R[0, 0] * F[0, 1] + R[1, 0] * F[1, 1] + R[2, 0] * F[2, 1]
    S02 = R[0, 0] * F[0, 2] + R[1, 0] * F[1, 2] + R[2, 0] * F[2, 2]
    S12 = R[0, 1] * F[0, 2] + R[1, 1] * F[1, 2] + R[2, 1] * F[2, 2]
    c = float(lam * (S00 + S11 + S22 - 3.0) - 2.0 * mu)
    a, b, d = S11 + S22, S00 + S22, S00 + S11  # tr(S) I − S has −S01, −S02, −S12 beside them
    C00, C11, C22 = b * d - S12 * S12, a * d - S02 * S02, a * b - S01 * S01
    C01, C02, C12 = S01 * d + S02 * S12, S01 * S12 + b * S02, a * S12 + S01 * S02
    det = a * C00 - S01 * C01 - S02 * C02
    # singular only for inverted elements, which keep the tangent with fixed rotations
    if not (exact and det > 1e-3):
        return c, (-mu, 0.0, 0.0, -mu, 0.0, -mu)
    w = c / det
    return c, (w * C00, w * C01, w * C02, w * C11, w * C12, w * C22)


@kernel
def project(e: int, V: float, c: float, R: Array, Q: Symmetric, body: Body, work: Work) -> None:
    """Rows t and a of element e and their images; its part of the force that is not linear in α.

    Args:
        e: number of the element in the sample.
        V: its weighted volume w V [m³].
        c: stress coefficient of `turning` [Pa].
        R: (3, 3) rotation of its deformation gradient.
        Q: symmetric matrix of `turning` [Pa].
        body: the elements.
        work: Z, Y and force are written.
    """
    G, Z, Y, force = body.gradient, work.Z, work.Y, work.force
    # scalars, because numba keeps them in registers where it would reload array entries
    R00, R01, R02, R10, R11, R12 = R[0, 0], R[0, 1], R[0, 2], R[1, 0], R[1, 1], R[1, 2]
    R20, R21, R22 = R[2, 0], R[2, 1], R[2, 2]
    Q00, Q01, Q02, Q11, Q12, Q22 = V * Q[0], V * Q[1], V * Q[2], V * Q[3], V * Q[4], V * Q[5]
    Vc, Vl = V * c, V * body.lame[0]
    g, z = 9 * e, 4 * e
    for j in range(G.shape[1]):
        G00, G01, G02 = G[g, j], G[g + 1, j], G[g + 2, j]
        G10, G11, G12 = G[g + 3, j], G[g + 4, j], G[g + 5, j]
        G20, G21, G22 = G[g + 6, j], G[g + 7, j], G[g + 8, j]
        t = R00 * G00 + R01 * G01 + R02 * G02 + R10 * G10 + R11 * G11 + R12 * G12
        t += R20 * G20 + R21 * G21 + R22 * G22
        a0 = R02 * G01 - R01 * G02 + R12 * G11 - R11 * G12 + R22 * G21 - R21 * G22
        a1 = R00 * G02 - R02 * G00 + R10 * G12 - R12 * G10 + R20 * G22 - R22 * G20
        a2 = R01 * G00 - R00 * G01 + R11 * G10 - R10 * G11 + R21 * G20 - R20 * G21
        force[j] -= Vc * t
        Z[z, j], Z[z + 1, j], Z[z + 2, j], Z[z + 3, j] = t, a0, a1, a2
        Y[z, j] = Vl * t
        Y[z + 1, j] = Q00 * a0 + Q01 * a1 + Q02 * a2
        Y[z + 2, j] = Q01 * a0 + Q11 * a1 + Q12 * a2
        Y[z + 3, j] = Q02 * a0 + Q12 * a1 + Q22 * a2


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
    alpha: Array, v: Array, tension: Array, load: Array, dynamics: Dynamics,
    body: Body, tendons: Tendons, work: Work,
) -> float:  # fmt: skip
    """Factors of A into work.L and v_free into work.v_free, as `tauten.model.system.make_system`.

    Args:
        alpha: (r,) state [m].
        v: (r,) its rate [m/s].
        tension: as in `assemble`.
        load: as in `assemble`.
        dynamics: mass, damping and time step.
        body: the elements.
        tendons: the cables.
        work: overwritten.

    Returns:
        Norm of the forces out of balance [N]; NaN when A is not positive definite.
    """
    h, a, b_K, mass = dynamics.h, dynamics.a, dynamics.b_K, dynamics.mass
    for exact in (True, False):  # buckling makes the exact tangent indefinite
        assemble_sample(alpha, tension, load, exact, body, tendons, work)
        if dynamics.static:
            work.A[:] = h * h * work.K
            work.v_free[:] = h * work.force
        else:
            work.A[:] = (1.0 + h * a) * mass + (h * b_K + h * h) * work.K
            Mv, Kv = np.dot(mass, v), np.dot(work.K, v)
            work.v_free[:] = h * (work.force - a * Mv - (b_K + h) * Kv)
        if cholesky(work.A, work.L):
            solve_in_place(work.L, work.v_free)
            if not dynamics.static:
                work.v_free[:] += v
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
