"""Energy-conserving sampling and weighting: few elements whose weighted forces replace the sum over all.

The reduced force is a sum over elements, Φᵀ f = Σ_e Φ_eᵀ f_e. A weighted sample of few elements gives nearly
the same sum at the states of a campaign:

    min |w|₀   s.t.   ‖C w − C 1‖ ≤ τ ‖C 1‖,   w ≥ 0

with a column of C for every element. Each sampled element has its own strain energy, multiplied by w, so the
sampled model has an energy, its tangent is symmetric, and rigid rotations cause no stress.
(Farhat, Avery, Chapman, Cortial, Int. J. Numerical Methods in Engineering 98, 2014.)

Most rows of C are forces at training states, and changes of force in random directions about them, so that
the tangent of the sample is accurate too. They are multiplied by K^(−1/2), so the squared residual is the
elastic energy of the deformation that the missing force would cause. One more row holds the volumes of the
elements: the sample has the volume of the body.
"""

from __future__ import annotations

import numpy as np

from tauten.model.materials import NO_TANGENT, WORK, response
from tauten.model.numerics import Array, Ints, kernel, polar_rotations, sparse_nnls
from tauten.model.tetra import Tetrahedra
from tauten.reduction.reduced_body import ElementSample
from tauten.reduction.state.tetra.points import gradients_of, integration_points

STATES = 40  # training states taken of a campaign, fewer where modes are many
MOST_ROWS = 12000  # of the training matrix, whose memory they limit
DIRECTIONS = 2  # random directions at each, for the tangent
SHARE = 0.1  # length of a direction, relative to the norm of its state
VOLUME = 0.1  # relative error of the sampled volume that counts as much as the whole tolerance
FLOOR = 1e-12  # stiffness that is none, relative to the largest
STEP = 1e-3  # step of the finite difference, relative to that length


def sample_elements(
    tetrahedra: Tetrahedra, Phi: Array, alphas: Array, tolerance: float, seed: int = 0
) -> ElementSample:
    """A sample of elements for states q₀ + Φ α.

    Args:
        tetrahedra: of the full model.
        Phi: (n, r) state modes.
        alphas: (r, s) states of a campaign [m]; some of them, far from each other, are training states.
        tolerance: relative residual.
        seed: of the random directions.
    """
    states = max(1, min(STATES, MOST_ROWS // ((1 + DIRECTIONS) * len(alphas))))
    C = contributions(tetrahedra, Phi, alphas[:, farthest_apart(alphas, states)], seed)
    d = C.sum(axis=1)
    volume = integration_points(tetrahedra).volume
    share = tolerance / VOLUME * np.linalg.norm(d) * volume / volume.sum()  # (e,)
    w = sparse_nnls(np.vstack([C, share]), np.append(d, share.sum()), tolerance)
    elements = np.flatnonzero(w)
    error = float(np.linalg.norm(C[:, elements] @ w[elements] - d) / np.linalg.norm(d))
    return ElementSample(elements, w[elements], error)


def farthest_apart(alphas: Array, count: int) -> Ints:
    """Numbers (min(count, s),) of states (r, s) far from each other, ascending.

    First the largest, then always the one farthest from all chosen (Gonzalez, Theoretical Computer Science
    38, 1985).
    """
    chosen = [int(np.argmax((alphas**2).sum(axis=0)))]
    distance = np.full(alphas.shape[1], np.inf)  # squares
    while len(chosen) < min(count, alphas.shape[1]):
        distance = np.minimum(distance, ((alphas - alphas[:, chosen[-1:]]) ** 2).sum(axis=0))
        distance[chosen] = -1.0
        chosen.append(int(np.argmax(distance)))
    return np.sort(np.array(chosen, dtype=np.int64))


def contributions(tetrahedra: Tetrahedra, Phi: Array, alphas: Array, seed: int) -> Array:
    """The training matrix C ((1 + DIRECTIONS) r s, e) [√J], one column for each element.

    Args:
        tetrahedra: of the full model.
        Phi: (n, r) state modes.
        alphas: (r, s) training states [m].
        seed: of the random directions.
    """
    rng = np.random.default_rng(seed)
    points, r = integration_points(tetrahedra), Phi.shape[1]
    G = gradients_of(tetrahedra, points, Phi, np.arange(len(points)))  # (9 e, r)
    laws = (points.kind, points.constants)
    C = np.empty((alphas.shape[1] * (1 + DIRECTIONS) * r, len(points)))
    row = 0
    for alpha in np.ascontiguousarray(alphas.T):
        root = compliance_root(tetrahedra, Phi, alpha)  # (r, r)
        blocks = [element_forces(alpha, G, points.volume, laws)]
        for _ in range(DIRECTIONS):
            step = root @ rng.normal(size=r)  # low-energy directions are likelier
            step *= STEP * SHARE * np.linalg.norm(alpha) / np.linalg.norm(step)
            forth = element_forces(alpha + step, G, points.volume, laws)
            back = element_forces(alpha - step, G, points.volume, laws)
            blocks.append((forth - back) / (2.0 * STEP))
        for block in blocks:
            C[row : row + r] = root @ block.T
            row += r
    return C


def compliance_root(tetrahedra: Tetrahedra, Phi: Array, alpha: Array) -> Array:
    """K^(−1/2) (r, r) of the reduced tangent [(m/N)^(1/2)], zero along motions without energy.

    Such are those of bodies that nothing holds, and all entries of rigid ones: nothing there is to sample.

    Args:
        tetrahedra: of the full model.
        Phi: (n, r) state modes.
        alpha: (r,) state [m].
    """
    x = tetrahedra.placed(tetrahedra.at_rest + Phi @ alpha)
    _, values = tetrahedra.forces(tetrahedra.elements.semidefinite, x, None)
    K = tetrahedra.pattern.matrix(values)
    energy, directions = np.linalg.eigh(Phi.T @ (K @ Phi))
    stiff = energy > FLOOR * energy.max()
    along = directions[:, stiff]
    root: Array = (along / np.sqrt(energy[stiff])) @ along.T
    return root


@kernel
def element_forces(alpha: Array, G: Array, volume: Array, laws: tuple[Ints, Array]) -> Array:
    """Force of each element along the modes, −V Gᵀ P: (e, r) [N].

    Args:
        alpha: (r,) state [m].
        G: (9 e, r) derivatives of the deformation gradients [1/m].
        volume: (e,) [m³].
        laws: kind (e,) and constants (e, 7) of each element's law.
    """
    kind, constants = laws
    forces = np.zeros((volume.shape[0], alpha.shape[0]))
    F = np.dot(G, alpha).reshape(-1, 3, 3) + np.eye(3)  # (e, 3, 3)
    R = np.empty_like(F)  # (e, 3, 3)
    polar_rotations(F, R)
    P, none, scratch = np.empty((3, 3)), np.empty((0, 0)), np.empty(WORK)
    for e in range(volume.shape[0]):
        response(kind[e], constants[e], F[e], R[e], NO_TANGENT, P, none, scratch)
        for i in range(3):
            for j in range(3):
                for k in range(alpha.shape[0]):
                    forces[e, k] -= volume[e] * P[i, j] * G[9 * e + 3 * i + j, k]
    return forces
