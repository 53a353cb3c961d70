"""State bases: directions of motion in a campaign, and directions in which forces move the robot.

Deviations from rest are Φ α (14), with columns that are orthonormal in a norm of the robot, ΦᵀWΦ = I
(`tauten.reduction.reduced_body.Reducible`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import svd

from tauten.model import ContactSpace, Robot, State, System
from tauten.model.numerics import Array, Ints
from tauten.reduction.campaign import Snapshots
from tauten.reduction.reduced_body import Reducible

RESPONSE_STATES = 3  # states of the campaign whose responses enrich a basis
NEGLIGIBLE = 1e-9  # response to a unit force, relative to the largest


@dataclass(frozen=True, slots=True, eq=False)
class Pod:
    """Proper orthogonal decomposition.

    Attributes:
        Phi: (m, r) modes, strongest first, ΦᵀWΦ = I.
        strength: (rank,) root mean square of each mode's coefficient over the snapshots.
    """

    Phi: Array
    strength: Array

    @property
    def error(self) -> float:
        """Root mean square of the motion outside the r modes, relative to all motion."""
        total = float(np.linalg.norm(self.strength))
        return float(np.linalg.norm(self.strength[self.Phi.shape[1] :])) / total


def pod(deviations: Array, weight: Array, r: int) -> Pod:
    """The r directions with the smallest projection error of the deviations, in the norm W.

    Args:
        deviations: (m, s) from rest.
        weight: (m,) diagonal of W, positive.
        r: number of modes; fewer are returned when the deviations have a smaller rank.

    Source: Sirovich, Quarterly of Applied Mathematics 45, 1987; weighted as in Volkwein, Model Reduction
    using Proper Orthogonal Decomposition, 2013.
    """
    root = np.sqrt(weight)  # (m,)
    U, sigma, _ = svd(root[:, None] * deviations, full_matrices=False, check_finite=False)
    rank = int((sigma > 1e-10 * sigma.max(initial=0.0)).sum())
    Phi = U[:, : min(r, rank)] / root[:, None]
    return Pod(np.ascontiguousarray(Phi), sigma[:rank] / np.sqrt(deviations.shape[1]))


def even_weights(runs: Ints) -> Array:
    """Factors (s,) of snapshots by which each of their runs (s,) counts the same, of mean square one."""
    _, number, sizes = np.unique(runs, return_inverse=True, return_counts=True)
    factors: Array = np.sqrt(len(runs) / (len(sizes) * sizes[number]))
    return factors


def enriched(Phi: Array, vectors: Array, weight: Array) -> Array:
    """Φ and orthonormal columns for the parts of some vectors outside its span.

    Args:
        Phi: (m, r) modes, ΦᵀWΦ = I.
        vectors: (m, k) directions to add.
        weight: (m,) diagonal of W, positive.

    Returns:
        (m, r + k') with k' ≤ k, the rank of those parts.

    Source: Gram-Schmidt twice (Giraud, Langou, Rozložník, Computers and Mathematics with Applications
    50, 2005).
    """
    columns = [Phi[:, j] for j in range(Phi.shape[1])]
    for vector in vectors.T:
        before, remainder = np.sqrt(vector @ (weight * vector)), vector
        for _ in range(2):
            basis = np.stack(columns, axis=1) if columns else np.zeros((len(weight), 0))
            remainder = remainder - basis @ (basis.T @ (weight * remainder))
        norm = np.sqrt(remainder @ (weight * remainder))
        if norm > 1e-6 * before:
            columns.append(remainder / norm)
    return np.stack(columns, axis=1)


def without_own(body: Reducible, vectors: Array) -> Array:
    """Deviations (m, k) with zeros in place of what is a coordinate of its own."""
    left = vectors.copy()
    left[len(left) - body.own_coordinates :] = 0.0
    return left


def with_own(body: Reducible, Phi: Array) -> Array:
    """Modes (m, r) without the robot's own coordinates and a unit mode for each: (m, r + o), orthonormal."""
    own, m = body.own_coordinates, len(Phi)
    units = np.zeros((m, own))
    units[np.arange(m - own, m), np.arange(own)] = 1.0 / np.sqrt(body.weight[m - own :])
    return np.ascontiguousarray(np.hstack([Phi, units]))


def kept_responses(system: System, H: Array, kept: Ints) -> Array:
    """Static responses (n, m) to unit forces of some rows, with some unknowns held where they are.

    Args:
        system: static, factorised.
        H: (m, n) rows.
        kept: (d,) unknowns that forces of their own hold.
    """
    E = np.zeros((H.shape[1], len(kept)))
    E[kept, np.arange(len(kept))] = 1.0
    motion, pulled = np.hsplit(system.solve(np.asfortranarray(np.hstack([H.T, E]))), [len(H)])
    found: Array = motion - pulled @ np.linalg.solve(pulled[kept], motion[kept])
    return found


def responses(robot: Robot, space: ContactSpace, state: State, effort: Array, kept: Ints) -> Array:
    """Static responses A⁻¹ Hᵀ to unit forces of each effector direction, cable, contact mode: (n, m).

    Args:
        robot: the full model; its workspace is used.
        space: contact modes; those without a candidate in range have no response.
        state: where the system is linearised.
        effort: (n_a,) cable tensions there [N].
        kept: (d,) unknowns that stay where they are.
    """
    system = robot.static_system(state, effort)
    rows = robot.rows(state)
    reduced = space.reduce(rows.contacts)
    H = np.vstack([rows.effectors.dense(), rows.actuators.dense(), reduced.H])
    return kept_responses(system, H, kept)


def touched_responses(robot: Robot, body: Reducible, touched: int) -> Array:
    """Static responses at rest to forces in three directions on places that something touches: (m, 3 k).

    With all of these in its span a reduced robot yields at the places as the full one does, near rest: the
    attachment modes of component mode synthesis (Craig, Modal Analysis 2, 1987).
    """
    if touched == 0:
        return np.zeros((len(body.weight), 0))
    rest = robot.rest()
    system = robot.static_system(rest)
    H = robot.rows(rest, contacts=False).effectors.dense()
    motion = kept_responses(system, H[-3 * touched :], body.kept_unknowns)
    return without_own(body, body.rates(rest.q, motion))


def campaign_responses(
    robot: Robot, body: Reducible, space: ContactSpace, snapshots: Snapshots
) -> Array:
    """Responses (m, k) at states spread over a campaign, orthonormal as Φ, strongest direction first."""
    chosen = np.linspace(0, len(snapshots) - 1, RESPONSE_STATES).round().astype(int)
    parts = []
    for i in chosen:
        state = State(snapshots.q[:, i], np.zeros(robot.n))
        effort = snapshots.effort[:, i]
        motion = responses(robot, space, state, effort, body.kept_unknowns)  # (n, k)
        found = without_own(body, body.rates(state.q, motion))  # (m, k)
        size = np.sqrt(body.weight @ found**2)  # (k,) per newton
        felt = size > NEGLIGIBLE * size.max()  # a mode may have nothing but tiny weights in range
        parts.append(found[:, felt] / size[felt])
    every = np.concatenate(parts, axis=1)
    return pod(every, body.weight, every.shape[1]).Phi
