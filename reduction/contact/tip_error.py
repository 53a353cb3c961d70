"""Tip error of a basis: reduced contact against the stored full-order equilibria, in metres."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from tauten.model import ContactSpace, Enrichment, Robot, Simulator, State
from tauten.model.numerics import Array, Bools
from tauten.reduction.campaign import MAX_ITERATIONS, TOLERANCE, Snapshots, pressed_by
from tauten.reduction.reduced_body import ReducedBody


@dataclass(frozen=True, slots=True, eq=False)
class TipErrors:
    """Effector errors of reduced contact relative to pointwise contact.

    Attributes:
        error: (s,) largest error of an effector, see `EffectorLayout.error` [m]; NaN where either did not
            converge.
        converged: (s,) whether the reduced equilibrium did.
        extra_columns: (s,) number of unit columns added by enrichment.
    """

    error: Array
    converged: Bools
    extra_columns: Array


def tip_errors(
    robot: Robot,
    snapshots: Snapshots,
    basis: ContactSpace,
    enrichment: Enrichment | None = None,
    held: Literal["position", "effort", "as held"] = "position",
    max_iterations: int = MAX_ITERATIONS,
    each: Callable[[], None] = lambda: None,
) -> TipErrors:
    """Solve for the equilibria of the snapshots with reduced contact and compare effectors.

    Every run starts from rest, so the error is that of the whole path, not of one step.

    Args:
        robot: the robot of the snapshots.
        snapshots: equilibria with full contact, runs one after the other.
        basis: contact modes.
        enrichment: rules for adding unit columns; None adds none.
        held: whether the stored positions or the stored efforts are prescribed, or of each actuator what the
            robot holds, of chambers the pressure. Errors are larger with efforts.
        max_iterations: of an equilibrium; more are needed where snapshots are far apart.
        each: called after each equilibrium.
    """
    simulator = Simulator(robot, contact=basis, enrichment=enrichment)
    layout, wanted = robot.effector_layout, snapshot_values(robot, snapshots)
    error = np.full(len(snapshots), np.nan)
    converged = np.zeros(len(snapshots), dtype=bool)
    extra = np.zeros(len(snapshots))
    for i in range(len(snapshots)):
        if i == 0 or snapshots.run[i] != snapshots.run[i - 1]:
            simulator.reset()
        simulator.load(snapshots.gravity[:, i], snapshots.effector_force[:, i])
        simulator.set_obstacles(pressed_by(simulator.obstacles, snapshots.pressed[:, i]))
        position, effort = snapshots.position[:, i], snapshots.effort[:, i]
        if held == "as held":
            command = robot.actuators.laws.held(position, effort)
            position, effort = command.position, command.effort
        report = simulator.settle(
            None if held == "effort" else position,
            None if held == "position" else effort,
            TOLERANCE,
            max_iterations,
        )
        converged[i], extra[i] = report.converged, report.extra_columns
        if converged[i] and snapshots.converged[i]:
            error[i] = layout.error(simulator.effector_values, wanted[i])
        each()
    return TipErrors(error, converged, extra)


def snapshot_values(robot: Robot, snapshots: Snapshots) -> Array:
    """Goal values (s, n_v) of the effectors at the equilibria of snapshots of a robot, or of its full one."""
    full = robot.body.full if isinstance(robot.body, ReducedBody) else robot
    still = np.zeros(full.n)
    return np.array([full.effector_values(State(q, still)) for q in snapshots.q.T])
