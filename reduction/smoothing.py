"""Contact forces of stored equilibria once more, under another regularisation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tauten.model.robot import Robot, State
from tauten.model.simulator import Simulator
from tauten.reduction.snapshots import Snapshots


def smoothed(robot: Robot, snapshots: Snapshots, regularisation: float) -> Snapshots:
    """The same equilibria with forces λ of another smoothness; nothing is settled again.

    Where candidates are finer than the mesh, many λ hold the robot in the same place. A larger
    regularisation spreads them, which makes them easier to factor and leaves more of the forces
    out of balance.

    Args:
        robot: whose snapshots these are.
        snapshots: equilibria with their configurations.
        regularisation: see `Simulator.smooth_contact_forces`.
    """
    simulator = Simulator(robot, contact="full")
    lam = np.zeros_like(snapshots.lam)  # (n_c, s)
    for i in np.flatnonzero(snapshots.converged):
        gravity, force = snapshots.gravity[:, i], snapshots.effector_force[:, i]
        simulator.robot = simulator.robot.loaded(gravity, force)
        simulator.state = State(snapshots.q[:, i], np.zeros(robot.n))
        simulator.forces = replace(simulator.forces, tension=snapshots.tension[:, i])
        lam[:, i] = simulator.smooth_contact_forces(regularisation)
    return replace(snapshots, lam=lam)
