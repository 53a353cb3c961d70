"""Energy-conserving sampling and weighting: few elements whose weighted forces replace the sum over all.

The reduced force is a sum over elements, Φᵀ f = Σ_e Φ_eᵀ f_e. A weighted sample of few elements gives nearly
the same sum at the states of a campaign:

    min |w|₀   s.t.   ‖C w − C 1‖ ≤ τ ‖C 1‖,   w ≥ 0

with a column of C for every element. Each sampled element has its own strain energy, multiplied by w, so the
sampled model has an energy, its tangent is symmetric, and rigid rotations cause no stress.
(Farhat, Avery, Chapman, Cortial, Int. J. Numerical Methods in Engineering 98, 2014.)

Rows of C are forces at training states, and changes of force in random directions about them, so that the
tangent of the sample is accurate too. They are multiplied by K^(−1/2), so the squared residual is the elastic
energy of the deformation that the missing force would cause.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from tauten.model import State
from tauten.model.numerics import Array, Ints, kernel, polar_rotations, sparse_nnls
from tauten.model.tetra import TetRobot
from tauten.reduction.state.body import element_gradients

STATES = 40  # training states taken of a campaign
DIRECTIONS = 2  # random directions at each, for the tangent
SHARE = 0.1  # length of a direction, relative to the norm of its state
STEP = 1e-3  # step of the finite difference, relative to that length


@dataclass(frozen=True, slots=True, eq=False)
class ElementSample:
    """Sampled elements and their weights.

    Attributes:
        elements: (s,) their numbers, ascending.
        weights: (s,) factors of their forces.
        error: relative residual ‖C w − C 1‖ / ‖C 1‖.
    """

    elements: Ints
    weights: Array
    error: float


def sample_elements(
    robot: TetRobot, Phi: Array, alphas: Array, tolerance: float, seed: int = 0
) -> ElementSample:
    """A sample of elements for states q₀ + Φ α.

    Args:
        robot: the full model.
        Phi: (n, r) state modes.
        alphas: (r, s) states of a campaign [m]; some of them, evenly spread, are training states.
        tolerance: relative residual.
        seed: of the random directions.
    """
    chosen = np.linspace(0, alphas.shape[1] - 1, min(STATES, alphas.shape[1])).round().astype(int)
    C = contributions(robot, Phi, alphas[:, chosen], seed)
    d = C.sum(axis=1)
    w = sparse_nnls(C, d, tolerance)
    elements = np.flatnonzero(w)
    error = float(np.linalg.norm(C[:, elements] @ w[elements] - d) / np.linalg.norm(d))
    return ElementSample(elements, w[elements], error)


def contributions(robot: TetRobot, Phi: Array, alphas: Array, seed: int) -> Array:
    """The training matrix C, one column for each element.

    Args:
        robot: the full model.
        Phi: (n, r) state modes.
        alphas: (r, s) training states [m].
        seed: of the random directions.

    Returns:
        ((1 + DIRECTIONS) r s, e) [√J].
    """
    rng = np.random.default_rng(seed)
    every, r = np.arange(robot.n_elements), Phi.shape[1]
    G = element_gradients(robot, Phi, every)  # (9 e, r)
    volume, lame = robot.corotational.volumes, robot.material.lame
    C = np.empty((alphas.shape[1] * (1 + DIRECTIONS) * r, len(every)))
    row = 0
    for alpha in np.ascontiguousarray(alphas.T):
        root = compliance_root(robot, Phi, alpha)  # (r, r)
        blocks = [element_forces(alpha, G, volume, lame)]
        for _ in range(DIRECTIONS):
            step = root @ rng.normal(size=r)  # low-energy directions are likelier
            step *= STEP * SHARE * np.linalg.norm(alpha) / np.linalg.norm(step)
            forth = element_forces(alpha + step, G, volume, lame)
            back = element_forces(alpha - step, G, volume, lame)
            blocks.append((forth - back) / (2.0 * STEP))
        for block in blocks:
            C[row : row + r] = root @ block.T
            row += r
    return C


def compliance_root(robot: TetRobot, Phi: Array, alpha: Array) -> Array:
    """K^(−1/2) of the reduced tangent with rotations held.

    Args:
        robot: the full model.
        Phi: (n, r) state modes.
        alpha: (r,) state [m].

    Returns:
        (r, r) [(m/N)^(1/2)].
    """
    state = State(robot.rest().q + Phi @ alpha, np.zeros(robot.n))
    _, values = robot.forces(state)
    pattern = robot.pattern
    K = sp.csc_array((values, pattern.indices, pattern.indptr), shape=(robot.n, robot.n))
    energy, directions = np.linalg.eigh(Phi.T @ (K @ Phi))
    root: Array = (directions / np.sqrt(energy)) @ directions.T
    return root


@kernel
def element_forces(alpha: Array, G: Array, volume: Array, lame: tuple[float, float]) -> Array:
    """Force of each element along the modes, −V Gᵀ P: (e, r) [N].

    Args:
        alpha: (r,) state [m].
        G: (9 e, r) derivatives of the deformation gradients [1/m].
        volume: (e,) [m³].
        lame: (λ, μ) [Pa].
    """
    lam, mu = lame
    forces = np.zeros((volume.shape[0], alpha.shape[0]))
    all_F = np.dot(G, alpha).reshape(-1, 3, 3) + np.eye(3)  # (e, 3, 3)
    all_R = np.empty_like(all_F)  # (e, 3, 3)
    polar_rotations(all_F, all_R)
    for e in range(volume.shape[0]):
        F, R = all_F[e], all_R[e]
        trace = -3.0
        for i in range(3):
            for j in range(3):
                trace += R[i, j] * F[i, j]
        for i in range(3):
            for j in range(3):
                P = 2.0 * mu * (F[i, j] - R[i, j]) + lam * trace * R[i, j]
                for k in range(alpha.shape[0]):
                    forces[e, k] -= volume[e] * P * G[9 * e + 3 * i + j, k]
    return forces
