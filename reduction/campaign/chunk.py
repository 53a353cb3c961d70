"""A chunk of a campaign: some equilibria of one run, a pure function of its task.

Chunks are what goes to a worker, what is saved, and where an interrupted campaign goes on. A chunk
starts from the stored end of the one before, whether or not anything was interrupted in between, so
neither interruptions nor the number of workers change a result.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from threadpoolctl import threadpool_limits

from tauten.model import Robot, Simulator, State
from tauten.model.numerics import Array, FactorisationError
from tauten.reduction.campaign.designs import Run
from tauten.reduction.campaign.snapshots import Origin, Snapshots

TOLERANCE = 1e-6  # largest movement in the last step of an equilibrium [m]
MAX_ITERATIONS = 60  # neighbours on a path are a few steps apart; who needs more oscillates


@dataclass(frozen=True, slots=True, eq=False)
class Start:
    """Where a chunk starts: configuration q (n,) [m] and cable tensions (n_a,) [N]."""

    q: Array
    tension: Array


@dataclass(frozen=True, slots=True, eq=False)
class Task:
    """All that a worker needs.

    Attributes:
        robot: whose equilibria are wanted.
        origin: of the snapshots.
        run: the equilibria of this chunk alone.
        index: number of the run they belong to.
        start: end of the chunk before; None starts at rest.
    """

    robot: Robot
    origin: Origin
    run: Run
    index: int
    start: Start | None


def visit(task: Task) -> Snapshots:
    """Settle into one equilibrium after the other and record forces and configurations.

    An equilibrium that does not converge is recorded as such; one that blows up is too, with zeros,
    and the next one is tried from the last state that did not.
    """
    with threadpool_limits(1):  # more threads would change sums, and workers are many already
        simulator = Simulator(task.robot, contact="full")
        if task.start is not None:
            simulator.state = State(task.start.q, np.zeros(task.robot.n))
            simulator.forces = replace(simulator.forces, tension=task.start.tension)
        columns = [_column(simulator, task.run, i) for i in range(len(task.run))]
    lam, pull, tension, effector, q, converged = (list(part) for part in zip(*columns, strict=True))
    return Snapshots(
        lam=np.stack(lam, axis=1),
        pull=np.stack(pull, axis=1) if task.run.tension is not None else task.run.pull,
        tension=np.stack(tension, axis=1),
        effector=np.stack(effector, axis=1),
        gravity=task.run.gravity,
        effector_force=task.run.effector_force,
        run=np.full(len(task.run), task.index, dtype=np.int64),
        converged=np.array(converged),
        q=np.stack(q, axis=1),
        origin=task.origin,
    )


def _column(
    simulator: Simulator, run: Run, i: int
) -> tuple[Array, Array, Array, Array, Array, bool]:
    """λ_c (n_c,), pull and tension (n_a,), effector (n_e,), q at equilibrium i; whether it is one."""
    simulator.robot = simulator.robot.loaded(run.gravity[:, i], run.effector_force[:, i])
    before = simulator.state, simulator.forces
    try:
        pull = run.pull[:, i] if run.tension is None else None
        tension = None if run.tension is None else run.tension[:, i]
        report = simulator.settle(pull, tension, TOLERANCE, MAX_ITERATIONS)
        lam_c = simulator.smooth_contact_forces()
        converged = report.converged and bool(np.isfinite(lam_c).all())
    except FactorisationError:
        converged = False
    if not np.isfinite(simulator.state.q).all() or not converged:
        simulator.state, simulator.forces = before
        lam_c = np.zeros(simulator.robot.n_c)
    forces, state = simulator.forces, simulator.state
    return lam_c, simulator.pull, forces.tension, simulator.effector.ravel(), state.q, converged
