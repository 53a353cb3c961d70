"""The contact problems of snapshots, with which the errors of a basis are computed.

At an equilibrium with actuators held, contact forces minimise

    f(λ) = ½ λᵀ W λ + δᵀ λ   over λ ≥ 0                                                (T4)

and reduced contact minimises the same over λ = Ψ β, β ≥ 0. So f(Ψ β) − f(λ) ≥ 0 is the energy, in joules,
that a basis loses there, and W_e (Ψ β − λ) the error of the effectors, to first order. Neither requires the
reduced equilibrium.

Cables that are taut and all other actuators keep their positions; where a spring is in series, that of the
motor. With `as_held`, those that a robot holds by their effort keep that instead: the errors of a robot with
chambers are then those at equal pressure, otherwise those at equal volume.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tauten.model import (
    Command,
    EmptySpace,
    Forces,
    Robot,
    State,
    condense_step,
    eliminate_rows,
    sorted_rows,
    under_friction,
)
from tauten.model.numerics import Array, Bools, Ints, solve_lcp
from tauten.reduction.campaign import Snapshots

COUNT = 100  # problems for a basis: more take longer and hardly change it


@dataclass(frozen=True, slots=True, eq=False)
class ContactProblem:
    """One equilibrium, condensed on the candidates in range.

    Attributes:
        W: (m, m) compliance of the candidates, actuators held [m/N].
        W_e: (3 q, m) displacement of the q parts of the effectors per contact force, actuators held [m/N],
            see `EffectorLayout.in_metres`.
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
    robot: Robot, snapshots: Snapshots, count: int = COUNT, as_held: bool = False
) -> tuple[ContactProblem, ...]:
    """The problems of converged snapshots with contact, at most `count`, evenly spread over all of them.

    As held, actuators that the robot holds by their effort keep their efforts.
    """
    touching = np.flatnonzero(snapshots.lam.any(axis=0))
    chosen = touching[
        np.linspace(0, len(touching) - 1, min(count, len(touching))).round().astype(int)
    ]
    workspace = robot.fork()
    by_effort = robot.actuators.laws.held_by_force & as_held
    return tuple(_problem(workspace, snapshots, int(column), by_effort) for column in chosen)


def _problem(robot: Robot, snapshots: Snapshots, column: int, by_effort: Bools) -> ContactProblem:
    """The problem of a snapshot."""
    loaded = robot.loaded(snapshots.gravity[:, column], snapshots.effector_force[:, column])
    state = State(snapshots.q[:, column], np.zeros(robot.n))
    effort = snapshots.effort[:, column]
    every = Forces(effort, np.zeros(0), np.arange(robot.n_c), np.ones(robot.n_c))
    static = replace(robot.integration, static=True)
    step = condense_step(loaded, EmptySpace(robot.n_c), state, every, True, True, static)
    step = under_friction(step, every)  # normal forces alone
    layout, W = step.layout, step.compliance.W  # of effectors, actuators, candidates
    given = Command.either(by_effort, snapshots.position[:, column], effort)
    rows = sorted_rows(step, given)
    taut = rows.cables[effort[rows.cables - layout.n_e] > 0.0]
    held = np.sort(np.concatenate([rows.equal, taut]))
    kept = np.concatenate([np.arange(layout.n_e), rows.contacts])
    rest = eliminate_rows(W, rows.under_effort(W), kept, held)
    c = slice(layout.n_e, None)  # of what is kept
    W_c, delta_c = rest.W[c, c], rest.delta[c]
    lam = solve_lcp(W_c, delta_c).lam
    energy = -float(0.5 * lam @ W_c @ lam + delta_c @ lam)
    slots = step.rows.contacts.slots
    W_e = robot.effector_layout.in_metres(rest.W[layout.effectors, c])
    return ContactProblem(W_c, W_e, delta_c, slots, lam, energy, column)
