"""The tangent of a density, projected to positive semidefinite through its principal stretches.

With F = U diag(σ) Vᵀ, both U and V rotations, ∂²ψ/∂F² has three kinds of entries in the frames U and V:

    A_ij = ∂²ψ/∂σᵢ∂σⱼ           between the entries (i, i) and (j, j)
    s_ij = (ψᵢ − ψⱼ)/(σᵢ − σⱼ)  eigenvalue of the symmetric pair of entries (i, j) and (j, i)
    t_ij = (ψᵢ + ψⱼ)/(σᵢ + σⱼ)  eigenvalue of their antisymmetric pair

Of densities in the invariants of `densities` both quotients are polynomials in σ plus, for S,
2 ψ_S / (σᵢ + σⱼ). The eigenvalues of the whole are those of A, the s_ij and the t_ij: making negative ones
zero gives the nearest positive semidefinite tangent.
(Smith, de Goes and Kim, Analytic Eigensystems for Isotropic Distortion Energies, ACM Transactions on
Graphics 38(1), 2019.)
"""

from __future__ import annotations

import numpy as np

from tauten.model.numerics import Array, kernel

THIRD = np.array([[0, 2, 1], [2, 1, 0], [1, 0, 2]])  # the index that is neither i nor j
SINGULAR = 1e-9  # σᵢ + σⱼ below which the rotation of F is not unique


@kernel
def projected_tangent(d: Array, F: Array, R: Array, C: Array) -> None:
    """The nearest positive semidefinite matrix to ∂²ψ/∂F².

    Args:
        d: (10,) derivatives of the density, see `densities.density` [Pa].
        F: (3, 3) deformation gradient.
        R: (3, 3) rotation of its polar decomposition.
        C: (9, 9) output, ∂P_iJ/∂F_kL in row 3 i + J and column 3 k + L [Pa].
    """
    U, V, sigma = np.empty((3, 3)), np.empty((3, 3)), np.empty(3)
    A, pairs = np.empty((3, 3)), np.empty((3, 2))
    principal_frames(F, R, U, V, sigma)
    principal_tangent(d, sigma, A, pairs)
    clamp(A)
    for row in range(3):
        pairs[row, 0] = max(pairs[row, 0], 0.0)
        pairs[row, 1] = max(pairs[row, 1], 0.0)
    from_principal_frames(A, pairs, U, V, C)


@kernel
def project_exact(d: Array, U: Array, V: Array, sigma: Array, C: Array) -> None:
    """`projected_tangent` of a density without S from its exact tangent: few eigenvalues are negative.

    Args:
        d: (10,) derivatives of the density, see `densities.density` [Pa].
        U: (3, 3) left singular vectors.
        V: (3, 3) right singular vectors.
        sigma: (3,) principal stretches σ.
        C: (9, 9) exact tangent, overwritten with the projected one [Pa].
    """
    scratch, mode = np.empty((3, 3, 3)), np.empty((3, 9))
    A, E, pairs = scratch[0], scratch[1], scratch[2, :, :2]
    principal_tangent(d, sigma, A, pairs)
    E[:] = A
    clamp(A)
    if A[0, 0] != E[0, 0] or A[1, 1] != E[1, 1] or A[2, 2] != E[2, 2]:
        for p in range(3):
            for m in range(9):
                mode[p, m] = U[m // 3, p] * V[m % 3, p]
        for p in range(3):
            for q in range(3):
                add_product(A[p, q] - E[p, q], mode[p], mode[q], C)
    for row in range(3):
        p, q = (0, 1) if row == 0 else ((0, 2) if row == 1 else (1, 2))
        for sign in range(2):
            value = pairs[row, sign]
            if value < 0.0:
                other = 1.0 if sign == 0 else -1.0
                for m in range(9):
                    i, j = m // 3, m % 3
                    mode[0, m] = U[i, p] * V[j, q] + other * U[i, q] * V[j, p]
                add_product(-0.5 * value, mode[0], mode[0], C)


@kernel
def add_product(factor: float, x: Array, y: Array, C: Array) -> None:
    """Add a multiple of x ⊗ y.

    Args:
        factor: of the product.
        x: (9,).
        y: (9,).
        C: (9, 9) added to.
    """
    for m in range(9):
        scaled = factor * x[m]
        for k in range(9):
            C[m, k] += scaled * y[k]


@kernel
def principal_frames(F: Array, R: Array, U: Array, V: Array, sigma: Array) -> None:
    """F = U diag(σ) Vᵀ from its rotation: the eigenvectors V of S = RᵀF, and U = R V.

    Args:
        F: (3, 3) deformation gradient.
        R: (3, 3) its rotation.
        U: (3, 3) output.
        V: (3, 3) output.
        sigma: (3,) output: principal stretches σ.
    """
    S = np.empty((3, 3))
    for i in range(3):
        for j in range(i, 3):
            a = R[0, i] * F[0, j] + R[1, i] * F[1, j] + R[2, i] * F[2, j]
            b = R[0, j] * F[0, i] + R[1, j] * F[1, i] + R[2, j] * F[2, i]
            S[i, j] = 0.5 * (a + b)
            S[j, i] = S[i, j]
    symmetric_eigen(S, V)
    for i in range(3):
        sigma[i] = S[i, i]
        for j in range(3):
            U[i, j] = R[i, 0] * V[0, j] + R[i, 1] * V[1, j] + R[i, 2] * V[2, j]


@kernel
def symmetric_eigen(S: Array, V: Array) -> None:
    """Diagonalise the symmetric 3x3 S in place by Jacobi's rotations; its eigenvectors into V."""
    for i in range(3):
        for j in range(3):
            V[i, j] = 1.0 if i == j else 0.0
    scale = abs(S[0, 0]) + abs(S[1, 1]) + abs(S[2, 2])
    for _ in range(8):
        off = abs(S[0, 1]) + abs(S[0, 2]) + abs(S[1, 2])
        if not off > 1e-15 * scale:  # also where it is not a number
            return
        for p in range(2):
            for q in range(p + 1, 3):
                if S[p, q] != 0.0:
                    turn(S, V, p, q)


@kernel
def turn(S: Array, V: Array, p: int, q: int) -> None:
    """One rotation of Jacobi that makes S[p, q] zero.

    Args:
        S: (3, 3) symmetric, overwritten.
        V: (3, 3) product of the rotations so far, overwritten.
        p: row of the entry.
        q: column of the entry.
    """
    theta = 0.5 * (S[q, q] - S[p, p]) / S[p, q]
    t = 1.0 / (abs(theta) + np.sqrt(theta * theta + 1.0))
    if theta < 0.0:
        t = -t
    c = 1.0 / np.sqrt(t * t + 1.0)
    s = t * c
    r = 3 - p - q
    S[p, p] -= t * S[p, q]
    S[q, q] += t * S[p, q]
    S[p, q] = 0.0
    S[q, p] = 0.0
    a, b = S[r, p], S[r, q]
    S[r, p] = c * a - s * b
    S[p, r] = S[r, p]
    S[r, q] = s * a + c * b
    S[q, r] = S[r, q]
    for i in range(3):
        a, b = V[i, p], V[i, q]
        V[i, p] = c * a - s * b
        V[i, q] = s * a + c * b


@kernel
def principal_tangent(d: Array, sigma: Array, A: Array, pairs: Array) -> None:
    """A (3, 3) and s_ij, t_ij (3, 2) of the pairs (0, 1), (0, 2), (1, 2) at stretches σ (3,).

    Args:
        d: derivatives of ψ [Pa].
        sigma: (3,) principal stretches σ.
        A: (3, 3) output [Pa].
        pairs: (3, 2) output: s_ij and t_ij [Pa].
    """
    dI = np.empty((4, 3))  # derivatives of the invariants by the stretches
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        dI[0, i] = 1.0
        dI[1, i] = 2.0 * sigma[i]
        dI[2, i] = 2.0 * sigma[i] * (sigma[j] ** 2 + sigma[k] ** 2)
        dI[3, i] = sigma[j] * sigma[k]
    for i in range(3):
        for j in range(i, 3):
            k = THIRD[i, j]
            second = d[5] + d[6] * dI[1, i] * dI[1, j] + d[9] * dI[3, i] * dI[3, j]
            second += d[7] * (dI[1, i] * dI[3, j] + dI[3, i] * dI[1, j])
            second += d[8] * (dI[2, i] * dI[3, j] + dI[3, i] * dI[2, j])
            if i == j:
                second += 2.0 * d[2]
                for m in range(3):
                    if m != i:
                        second += 2.0 * d[3] * sigma[m] ** 2
            else:
                second += 4.0 * d[3] * sigma[i] * sigma[j] + d[4] * sigma[k]
                square, product = sigma[k] ** 2, sigma[i] * sigma[j]
                total = sigma[i] + sigma[j]
                row = i + j - 1
                pairs[row, 0] = 2.0 * d[2] + 2.0 * d[3] * (square - product) - d[4] * sigma[k]
                pairs[row, 1] = 2.0 * d[2] + 2.0 * d[3] * (square + product) + d[4] * sigma[k]
                if d[1] != 0.0:
                    # where the rotation is not unique its turning is left out
                    pairs[row, 1] += 2.0 * d[1] / total if total > SINGULAR else -2.0 * d[2]
            A[i, j] = second
            A[j, i] = second


@kernel
def clamp(A: Array) -> None:
    """Replace the symmetric 3x3 A by the nearest positive semidefinite matrix."""
    minor = A[0, 0] * A[1, 1] - A[0, 1] * A[0, 1]
    det = A[2, 2] * minor - A[1, 2] * (A[0, 0] * A[1, 2] - A[0, 1] * A[0, 2])
    det += A[0, 2] * (A[0, 1] * A[1, 2] - A[1, 1] * A[0, 2])
    if A[0, 0] > 0.0 and minor > 0.0 and det > 0.0:  # most are
        return
    E, Q = A.copy(), np.empty((3, 3))
    symmetric_eigen(E, Q)
    if E[0, 0] >= 0.0 and E[1, 1] >= 0.0 and E[2, 2] >= 0.0:
        return
    A[:] = 0.0
    for p in range(3):
        value = max(E[p, p], 0.0)
        for i in range(3):
            for j in range(3):
                A[i, j] += value * Q[i, p] * Q[j, p]


@kernel
def from_principal_frames(A: Array, pairs: Array, U: Array, V: Array, C: Array) -> None:
    """Σ A_pq D_p ⊗ D_q + Σ s (symmetric pair) ⊗ (same) + Σ t (antisymmetric pair) ⊗ (same) into C (9, 9).

    D_p = u_p v_pᵀ; the pairs are (u_p v_qᵀ ± u_q v_pᵀ) / √2.

    Args:
        A: (3, 3) of `principal_tangent` [Pa].
        pairs: (3, 2) of `principal_tangent` [Pa].
        U: (3, 3) left singular vectors.
        V: (3, 3) right singular vectors.
        C: (9, 9) output [Pa].
    """
    D, Y = np.empty((9, 9)), np.empty((9, 9))  # modes, and modes times eigenvalues
    for i in range(3):
        for j in range(3):
            m = 3 * i + j
            for p in range(3):
                D[p, m] = U[i, p] * V[j, p]
            for row in range(3):
                p, q = (0, 1) if row == 0 else ((0, 2) if row == 1 else (1, 2))
                a, b = U[i, p] * V[j, q], U[i, q] * V[j, p]
                D[3 + row, m] = a + b
                D[6 + row, m] = a - b
    for m in range(9):
        for p in range(3):
            Y[p, m] = A[p, 0] * D[0, m] + A[p, 1] * D[1, m] + A[p, 2] * D[2, m]
            Y[3 + p, m] = 0.5 * pairs[p, 0] * D[3 + p, m]
            Y[6 + p, m] = 0.5 * pairs[p, 1] * D[6 + p, m]
    C[:] = 0.0
    for p in range(9):
        for m in range(9):
            for k in range(9):
                C[m, k] += D[p, m] * Y[p, k]
