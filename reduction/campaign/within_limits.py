"""Equilibria under efforts that take no actuator beyond the limits of its position."""

from __future__ import annotations

import numpy as np

from tauten.model import Simulator
from tauten.model.numerics import Array
from tauten.model.simulation import Report

ROUNDS = 4  # of actuators that come to a limit by what the others do there
BEYOND = 1e-3  # of the range of a position, from which on it counts as beyond its limit


def settle_within_limits(
    simulator: Simulator,
    position: Array,
    effort: Array | None,
    tolerance: float,
    max_iterations: int,
) -> Report:
    """Move to equilibrium under a command; what an effort takes beyond a limit of its position stays there.

    A winch that cannot pay out beyond rest, for example, holds the length of the cable on the outer side of
    a bend, whatever tension is commanded.

    Args:
        simulator: that moves.
        position: (n_a,) positions; NaN where efforts are commanded.
        effort: (n_a,) efforts; NaN where positions are commanded; None: none is.
        tolerance: largest displacement of a node in the last step [m].
        max_iterations: linearised steps at most, of each equilibrium.
    """
    report = simulator.settle(position, effort, tolerance, max_iterations)
    if effort is None:
        return report
    limits = simulator.robot.limits
    low, high = limits.position_min, limits.position_max
    slack = BEYOND * (high - low)
    for _ in range(ROUNDS):
        found = simulator.position
        beyond = np.isnan(position) & ((found < low - slack) | (found > high + slack))
        if not report.converged or not beyond.any():
            break
        position = np.where(beyond, np.clip(found, low, high), position)
        effort = np.where(beyond, np.nan, effort)
        report = simulator.settle(position, effort, tolerance, max_iterations)
    return report
