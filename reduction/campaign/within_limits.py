"""Equilibria under efforts that take no actuator beyond the limits of its position, and smaller limits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tauten.model import Robot, Simulator
from tauten.model.numerics import Array
from tauten.model.simulation import Report

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
    for _ in range(len(position)):  # each round holds at least one more, where they go on
        found = simulator.position
        beyond = np.isnan(position) & ((found < low - slack) | (found > high + slack))
        if not report.converged or not beyond.any():
            break
        position = np.where(beyond, np.clip(found, low, high), position)
        effort = np.where(beyond, np.nan, effort)
        report = simulator.settle(position, effort, tolerance, max_iterations)
    return report


def narrowed(robot: Robot, reached: Array, share: float) -> Robot:
    """The robot with limits of positions that are a share of what its actuators reach within the old ones.

    Args:
        robot: the robot.
        reached: (n_a, s) positions in a campaign of it.
        share: of the largest ones.
    """
    size, limits = share * np.abs(reached).max(axis=1), robot.limits  # (n_a,)
    # a slack cable may be shorter than its winch can wind it
    low = np.maximum(share * limits.position_min, -size)
    high = np.minimum(share * limits.position_max, size)
    return replace(robot, limits=replace(limits, position_min=low, position_max=high))
