"""The frame of a region: position and orientation of the rigid motion that fits its nodes best.

With ρ_i the rest positions relative to their mean, the rotation that minimises Σ |x_i − x̄ − R ρ_i|² is that
of the polar decomposition

    A = Σ (x_i − x̄) ρ_iᵀ = R U,   U symmetric                                                  (E1)

(Kabsch, Acta Crystallographica A32, 1976, 922), right-handed also where A is singular, as of a flat
region, or mirrored: then the smallest direction of U has the other sign. Because Σ ρ_i = 0, the mean x̄
drops out of A, and both are linear in the nodes: x̄ and the columns of A are four points in the sense of
`tauten.model.effectors.measure`. With δR = R [ω]x the derivative follows from the antisymmetric part of
Rᵀ δA = [ω]x U + δU,

    (tr(U) I − U) ω = Σ_k e_k x Rᵀ δA_k,                                                        (E2)

exact and smooth as long as no two of the eigenvalues of U sum to zero: for any region that is not
a line.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.effectors.measure import Measurement
from tauten.model.numerics import Array, kernel, matrix_quaternion, mirrored_rotation

STRAIGHT = 1e-3  # extent of a region across its longest direction, relative to that along it
# Relative; added to (E2), so that a region that is crushed to a line gives finite rows
SINGULAR = 1e-12


@dataclass(frozen=True, slots=True)
class FrameMeasure:
    """A frame as a function of its mean and moments (E1).

    Attributes:
        origin: (3,) its origin relative to the mean, in its own axes [m].
        weights: (4, P) of its points in the mean and in the columns of A; None: its points are these four.
    """

    origin: Array
    weights: Array | None = None

    @property
    def carrier(self) -> Array:
        """Weights (P,) of its points in the place where outer forces act on it: the mean of the region."""
        return np.array([1.0, 0.0, 0.0, 0.0]) if self.weights is None else self.weights[0]

    def at(self, y: Array) -> Measurement:
        """The effector for positions y (P, 3) of its points [m]."""
        means = y if self.weights is None else self.weights @ y
        position, q, gradient = frame_of(np.ascontiguousarray(means), self.origin)
        if self.weights is not None:
            gradient = np.einsum("mab,ap->mpb", gradient, self.weights)
        values = np.concatenate([position, q])
        return Measurement(values, np.concatenate([position, np.zeros(3)]), position, gradient)


@kernel
def frame_of(y: Array, origin: Array) -> tuple[Array, Array, Array]:
    """Position (3,), quaternion (4,) and gradient (6, 4, 3) of a frame.

    Args:
        y: (4, 3) mean [m] and columns of A.
        origin: (3,) relative to the mean, in the frame's axes [m].
    """
    A = y[1:].T.copy()
    R = mirrored_rotation(A)
    U = R.T.copy() @ A
    trace = U[0, 0] + U[1, 1] + U[2, 2]
    gradient = np.zeros((6, 4, 3))
    system = -0.5 * (U + U.T)
    for i in range(3):
        system[i, i] += trace + SINGULAR * abs(trace) + 1e-300
    turn = np.linalg.inv(system)
    for k in range(3):  # ω by column k of A: turn @ [e_k]x Rᵀ
        i, j = (k + 1) % 3, (k + 2) % 3
        for m in range(3):
            for b in range(3):
                # e_k x a has −a_j as component i and a_i as component j
                gradient[3 + m, 1 + k, b] = turn[m, j] * R[b, i] - turn[m, i] * R[b, j]
    lever = np.zeros((3, 3))  # −R [origin]x
    for a in range(3):
        lever[a, 0] = -(R[a, 1] * origin[2] - R[a, 2] * origin[1])
        lever[a, 1] = -(R[a, 2] * origin[0] - R[a, 0] * origin[2])
        lever[a, 2] = -(R[a, 0] * origin[1] - R[a, 1] * origin[0])
    for a in range(3):
        gradient[a, 0, a] = 1.0
        for k in range(1, 4):
            for b in range(3):
                for m in range(3):
                    gradient[a, k, b] += lever[a, m] * gradient[3 + m, k, b]
    return y[0] + R @ origin, matrix_quaternion(R), gradient


def frame_coefficients(rest: Array) -> Array:
    """Coefficients (4, N) of nodes (N, 3) at rest in their mean and in the columns of A.

    Raises:
        ValueError: fewer than three nodes, or all near a line.
    """
    if len(rest) < 3:
        raise ValueError(f"found {len(rest)} nodes, a frame needs at least three not on a line")
    rho = rest - rest.mean(axis=0)
    extent = np.linalg.svd(rho, compute_uv=False)
    if extent[1] <= STRAIGHT * extent[0]:
        raise ValueError(f"found {len(rest)} nodes on a line, a frame needs others beside it")
    # relative to their size: A has the order of one at rest
    return np.vstack([np.full(len(rest), 1.0 / len(rest)), rho.T / extent[0] ** 2])
