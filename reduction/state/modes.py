"""State bases: directions of motion in a campaign, and directions in which forces move the robot.

q = q₀ + Φ α (14). Columns are orthonormal in the mass, Φᵀ M Φ = m I with m the body's mass, so α is in
metres and |α| is the root mean square displacement of the body. Fixed nodes have no rows in Φ,
so they do not move.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import svd

from tauten.model import ContactSpace, State
from tauten.model.numerics import Array
from tauten.model.tetra import TetRobot
from tauten.reduction.campaign import Snapshots

RESPONSE_STATES = 3  # states of the campaign whose responses enrich a basis


@dataclass(frozen=True, slots=True, eq=False)
class Pod:
    """Proper orthogonal decomposition.

    Attributes:
        Phi: (n, r) modes, strongest first, ΦᵀMΦ = m I.
        strength: (rank,) root mean square of each mode's coefficient over the snapshots [m].
    """

    Phi: Array
    strength: Array

    @property
    def error(self) -> float:
        """Root mean square of the motion outside the r modes, relative to all motion."""
        total = float(np.linalg.norm(self.strength))
        return float(np.linalg.norm(self.strength[self.Phi.shape[1] :])) / total


def pod(deviations: Array, mass: Array, r: int) -> Pod:
    """The r directions with the smallest projection error of the deviations, in the norm of the mass.

    Args:
        deviations: (n, s) q − q₀ [m].
        mass: (n,) lumped mass, every node three times [kg].
        r: number of modes; fewer are returned when the deviations have a smaller rank.

    Source: Sirovich, Quarterly of Applied Mathematics 45, 1987; weighted as in Volkwein, Model Reduction
    using Proper Orthogonal Decomposition, 2013.
    """
    root = np.sqrt(3.0 * mass / mass.sum())  # (n,), Σ mass is three times the body's
    U, sigma, _ = svd(root[:, None] * deviations, full_matrices=False, check_finite=False)
    rank = int((sigma > 1e-10 * sigma.max(initial=0.0)).sum())
    Phi = U[:, : min(r, rank)] / root[:, None]
    return Pod(np.ascontiguousarray(Phi), sigma[:rank] / np.sqrt(deviations.shape[1]))


def enriched(Phi: Array, vectors: Array, mass: Array) -> Array:
    """Φ and orthonormal columns for the parts of some vectors outside its span.

    Args:
        Phi: (n, r) modes, orthonormal in the mass.
        vectors: (n, m) directions to add.
        mass: (n,) lumped mass, every node three times [kg].

    Returns:
        (n, r + m') with m' ≤ m, the rank of those parts.

    Source: Gram-Schmidt twice (Giraud, Langou, Rozložník, Computers and Mathematics with Applications
    50, 2005).
    """
    weight = 3.0 * mass / mass.sum()  # (n,)
    columns = [Phi[:, j] for j in range(Phi.shape[1])]
    for vector in vectors.T:
        before, remainder = np.sqrt(vector @ (weight * vector)), vector
        for _ in range(2):
            basis = np.stack(columns, axis=1) if columns else np.zeros((len(mass), 0))
            remainder = remainder - basis @ (basis.T @ (weight * remainder))
        norm = np.sqrt(remainder @ (weight * remainder))
        if norm > 1e-6 * before:
            columns.append(remainder / norm)
    return np.stack(columns, axis=1)


def responses(robot: TetRobot, space: ContactSpace, state: State, tension: Array) -> Array:
    """Static responses A⁻¹ Hᵀ to unit forces of each effector direction, cable, contact mode: (n, m).

    Args:
        robot: the full model; its workspace is used.
        space: contact modes; those without a candidate in range have no response.
        state: where the system is linearised.
        tension: (n_a,) cable tensions there [N].
    """
    system = robot.linearise(state, tension, replace(robot.integration, static=True))
    rows = robot.rows(state)
    reduced = space.reduce(rows.contacts)
    H = np.vstack([rows.effectors.dense(), rows.actuators.dense(), reduced.H])
    return system.solve(H.T)


def campaign_responses(robot: TetRobot, space: ContactSpace, snapshots: Snapshots) -> Array:
    """Responses at a few states spread over a campaign, strongest direction first.

    Args:
        robot: the full model; its workspace is used.
        space: contact modes.
        snapshots: equilibria with configurations.

    Returns:
        (n, m), orthonormal in the mass.
    """
    chosen = np.linspace(0, len(snapshots) - 1, RESPONSE_STATES).round().astype(int)
    parts = []
    for i in chosen:
        state = State(snapshots.q[:, i], np.zeros(robot.n))
        found = responses(robot, space, state, snapshots.tension[:, i])  # (n, m)
        parts.append(found / np.linalg.norm(found, axis=0))
    every = np.concatenate(parts, axis=1)
    return pod(every, robot.mass, every.shape[1]).Phi
