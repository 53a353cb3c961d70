"""The contact problems of snapshots, with which the errors of a basis are computed.

At an equilibrium with pulled lengths held, contact forces minimise

    f(λ) = ½ λᵀ W λ + δᵀ λ   over λ ≥ 0                                                (T4)

and reduced contact minimises the same over λ = Ψ β, β ≥ 0. So f(Ψ β) − f(λ) ≥ 0 is the energy, in joules,
that a basis loses there, and W_e (Ψ β − λ) the error of the effectors, to first order. Neither requires the
reduced equilibrium.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tauten.model import Robot, State, row_compliance
from tauten.model.numerics import Array, Ints, solve_lcp
from tauten.reduction.campaign import Snapshots

COUNT = 100  # problems for a basis: more take longer and hardly change it


@dataclass(frozen=True, slots=True, eq=False)
class ContactProblem:
    """One equilibrium, condensed on the candidates in range.

    Attributes:
        W: (m, m) compliance of the candidates, cables held [m/N].
        W_e: (3 q, m) displacement of the q parts of the effectors per contact force, cables held [m/N], see
            `EffectorLayout.in_metres`.
        delta: (m,) gaps without contact forces [m].
        slots: (m,) slot in λ_c of each candidate.
        lam: (m,) contact forces [N].
        energy: −f(λ), the decrease of the energy by contact forces [J].
        column: number of the snapshot.
    """

    W: Array
    W_e: Array
    delta: Array
    slots: Ints
    lam: Array
    energy: float
    column: int

    def coefficients(self, Psi: Array) -> Array:
        """Coefficients β (k,) [N] of reduced contact with modes Psi (n_c, k)."""
        modes = Psi[self.slots]  # (m, k)
        return solve_lcp(modes.T @ self.W @ modes, modes.T @ self.delta).lam

    def loss(self, lam: Array) -> float:
        """Energy lost with forces (m,): f above its minimum [J]."""
        return float(0.5 * lam @ self.W @ lam + self.delta @ lam) + self.energy

    def forces(self, Psi: Array) -> Array:
        """Contact forces Ψ β (m,) [N] of reduced contact with modes Psi (n_c, k)."""
        lam: Array = Psi[self.slots] @ self.coefficients(Psi)  # (m,)
        return lam

    def force_error(self, lam: Array) -> float:
        """Error of the sum of forces (m,) [N]; single forces are not unique."""
        return float(abs((lam - self.lam).sum()))

    def tip_error(self, lam: Array) -> float:
        """Largest error of an effector position with forces (m,), to first order [m]."""
        apart = self.W_e @ (lam - self.lam)  # (3 q,)
        return float(np.linalg.norm(apart.reshape(-1, 3), axis=1).max(initial=0.0))


def contact_problems(
    robot: Robot, snapshots: Snapshots, count: int = COUNT
) -> tuple[ContactProblem, ...]:
    """The problems of some snapshots with contact, evenly spread over all of them.

    Args:
        robot: the robot of the snapshots.
        snapshots: converged ones.
        count: largest number of problems.
    """
    touching = np.flatnonzero(snapshots.lam.any(axis=0))
    chosen = touching[
        np.linspace(0, len(touching) - 1, min(count, len(touching))).round().astype(int)
    ]
    workspace = robot.fork()
    return tuple(_problem(workspace, snapshots, int(column)) for column in chosen)


def _problem(robot: Robot, snapshots: Snapshots, column: int) -> ContactProblem:
    loaded = robot.loaded(snapshots.gravity[:, column], snapshots.effector_force[:, column])
    state = State(snapshots.q[:, column], np.zeros(robot.n))
    tension = snapshots.tension[:, column]
    rows = loaded.rows(state)
    system = loaded.linearise(state, tension, replace(robot.integration, static=True))
    parts = (rows.effectors, rows.actuators, rows.contacts.rows)
    all_rows = row_compliance(
        system,
        np.vstack([part.dense() for part in parts]),
        np.concatenate([part.delta for part in parts]),
    )
    W, delta = all_rows.W, all_rows.delta_free.copy()
    delta[robot.n_e : robot.n_e + robot.n_a] -= snapshots.pull[:, column]
    taut = robot.n_e + np.flatnonzero(
        tension > 0.0
    )  # taut cables have their pulled lengths prescribed
    share = np.linalg.solve(W[np.ix_(taut, taut)], np.c_[W[taut], delta[taut]])  # (t, rows + 1)
    W, delta = W - W[:, taut] @ share[:, :-1], delta - W[:, taut] @ share[:, -1]
    contact = slice(robot.n_e + robot.n_a, None)
    W_c, delta_c = W[contact, contact], delta[contact]
    lam = solve_lcp(W_c, delta_c).lam
    energy = -float(0.5 * lam @ W_c @ lam + delta_c @ lam)
    slots = rows.contacts.slots
    W_e = robot.effector_layout.in_metres(W[: robot.n_e, contact])
    return ContactProblem(W_c, W_e, delta_c, slots, lam, energy, column)
