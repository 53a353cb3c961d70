"""A chunk of a campaign: some consecutive equilibria of one run, a pure function of its input.

A worker computes one chunk at a time, chunks are saved, and an interrupted campaign continues after its last
saved chunk. A chunk starts from the stored end of the previous one, with or without an interruption between
them, so neither interruptions nor the number of workers change a result.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tauten.model import Robot, Simulator, State, one_blas_thread
from tauten.model.numerics import Array, FactorisationError
from tauten.reduction.campaign.designs import Run
from tauten.reduction.campaign.snapshots import Origin, Snapshots
from tauten.reduction.campaign.touched import pressed_by
from tauten.reduction.campaign.within_limits import settle_within_limits

TOLERANCE = 1e-6  # largest movement in the last step of an equilibrium [m]
MAX_ITERATIONS = 60  # neighbours on a path are a few steps apart; more iterations mean oscillation


@dataclass(frozen=True, slots=True, eq=False)
class Chunk:
    """The input of a worker.

    Attributes:
        robot: the robot.
        origin: of the snapshots.
        run: the equilibria of this chunk alone.
        index: number of the run they belong to.
        start: end of the previous chunk, its configuration (n,) [m] and efforts (n_a,) [N]; None starts at
            rest.
    """

    robot: Robot
    origin: Origin
    run: Run
    index: int
    start: tuple[Array, Array] | None


def solve_chunk(chunk: Chunk) -> Snapshots:
    """Solve for one equilibrium after the other and record forces and configurations.

    An equilibrium that is found neither at once nor in load steps is recorded as not converged, with zero
    contact forces, and the next one starts from the last state that converged.
    """
    with one_blas_thread():  # the order of sums depends on the number of threads
        simulator = Simulator(chunk.robot, contact="full")
        if chunk.start is not None:
            begin, held = chunk.start
            forces = replace(simulator.forces, effort=held)
            simulator.start_from(State(begin, np.zeros(chunk.robot.n)), forces)
        columns = [_column(simulator, chunk.run, i) for i in range(len(chunk.run))]
    lam, position, effort, effector, q, converged = (
        list(part) for part in zip(*columns, strict=True)
    )
    return Snapshots(
        lam=np.stack(lam, axis=1),
        position=np.stack(position, axis=1) if chunk.run.effort is not None else chunk.run.position,
        effort=np.stack(effort, axis=1),
        effector=np.stack(effector, axis=1),
        gravity=chunk.run.gravity,
        effector_force=chunk.run.effector_force,
        pressed=np.zeros((0, len(chunk.run))) if chunk.run.pressed is None else chunk.run.pressed,
        run=np.full(len(chunk.run), chunk.index, dtype=np.int64),
        converged=np.array(converged),
        q=np.stack(q, axis=1),
        origin=chunk.origin,
    )


def _column(
    simulator: Simulator, run: Run, i: int
) -> tuple[Array, Array, Array, Array, Array, bool]:
    """λ_c (n_c,), pull and tension (n_a,), effector (3 p,), q at equilibrium i; whether it is one."""
    simulator.load(run.gravity[:, i], run.effector_force[:, i])
    if run.pressed is not None:
        simulator.set_obstacles(pressed_by(simulator.obstacles, run.pressed[:, i]))
    before = simulator.state, simulator.forces
    try:
        position = run.position[:, i]
        effort = None if run.effort is None else run.effort[:, i]
        report = settle_within_limits(simulator, position, effort, TOLERANCE, MAX_ITERATIONS)
        lam_c = simulator.smooth_contact_forces()
        converged = report.converged and bool(np.isfinite(lam_c).all())
    except FactorisationError:
        converged = False
    if not np.isfinite(simulator.state.q).all() or not converged:
        simulator.start_from(*before)
        lam_c = np.zeros(simulator.robot.n_c)
    forces, state = simulator.forces, simulator.state
    return lam_c, simulator.position, forces.effort, simulator.effector.ravel(), state.q, converged
