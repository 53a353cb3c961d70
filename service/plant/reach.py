"""Where an effector gets: equilibria of the model under commands of the actuators that move it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tauten.model import Simulator
from tauten.model.numerics import Array, Bools, Ints
from tauten.reduction.campaign import command_range
from tauten.service.plant.paths import moved_by_actuators

CURVE, CLOUD = 33, 200  # equilibria: of one actuator, whose reach is a curve, and of several
_MOVES = 1e-3  # of the largest movement by an actuator; others do not move the effector
_SETTLED = 1e-3  # of the robot's size, in the last step of an equilibrium
_ITERATIONS = 60
_BEYOND = 1e-2  # of an effort's limit that an equilibrium may be beyond


@dataclass(frozen=True, slots=True)
class ReachPlan:
    """Commands whose equilibria show the reach of an effector.

    Attributes:
        effector: its number.
        shares: (m, n_a) of the actuators' ranges.
        is_curve: whether one actuator alone moves it, and the shares ascend.
    """

    effector: int
    shares: Array
    is_curve: bool


def reach_plan(simulator: Simulator, effector: int) -> ReachPlan:
    """Commands for an effector.

    One actuator goes through its range; of several, each goes to a random share of it or stays at rest.
    """
    moving = np.flatnonzero(_moving(simulator, effector))
    reach = command_range(simulator.robot)
    shares = np.zeros((CURVE if len(moving) == 1 else CLOUD, simulator.robot.n_a))
    if len(moving) == 1:
        low = -1.0 if reach.least[moving[0]] < 0.0 else 0.0
        shares[:, moving[0]] = np.linspace(low, 1.0, len(shares))
    else:
        shares[1:, moving] = _spread(moving, reach.least, len(shares) - 1)
    return ReachPlan(effector, shares, len(moving) == 1)


def reached(simulator: Simulator, plan: ReachPlan) -> Iterator[Array]:
    """Positions (3,) [m] of the effector in the equilibria that are found within the limits of efforts."""
    reach, limits, start = command_range(simulator.robot), simulator.robot.limits, simulator.state
    first = simulator.robot.effector_layout.values_of(plan.effector).start
    for share in plan.shares:
        held = reach.command(share)
        report = simulator.settle(
            held.position, held.effort, _SETTLED * simulator.robot.size, _ITERATIONS, load_steps=False
        )  # fmt: skip
        if not report.converged:
            simulator.start_from(start)
            continue
        effort = simulator.effort
        beyond = np.maximum(effort - limits.effort_max, limits.effort_min - effort)  # (n_a,)
        if (beyond <= _BEYOND * limits.largest_effort).all():
            yield simulator.effector_values[first : first + 3]


def _moving(simulator: Simulator, effector: int) -> Bools:
    """Which actuators (n_a,) move an effector, to first order."""
    moved = moved_by_actuators(simulator.robot, simulator.state, effector)
    moved = np.linalg.norm(moved, axis=0)  # (n_a,)
    found: Bools = moved > _MOVES * moved.max()
    return found


def _spread(moving: Ints, least: Array, count: int) -> Array:
    """Shares (count, k): of some actuators at once, each in its range."""
    random = np.random.default_rng(0)
    low = np.where(least[moving] < 0.0, -1.0, 0.0)
    shares = low + (1.0 - low) * random.random((count, len(moving)))
    shares[random.random(shares.shape) < 0.5] = 0.0
    return shares
