"""How far a robot's actuators can be commanded, one alone, before a limit of its position or effort is met.

Campaigns, paths and comparisons need loads that have an equilibrium. Limits in a robot file are those of the
motors; a soft robot often gives in long before.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tauten.model import Command, Robot, Simulator, static_compliance
from tauten.model.numerics import Array, Bools
from tauten.reduction.campaign.within_limits import settle_within_limits

# Called with the share that is done since the last call, and with what is being done.
Report = Callable[[float, str], None]

BEYOND = 3.0  # how much farther than to first order an effort may lead
OPPOSES = 0.01  # share of two cables' own compliances that the compliance between them is at least
ITERATIONS = 60  # of an equilibrium
TOLERANCE = 1e-5  # of equilibria, relative to the size of the robot


@dataclass(frozen=True, slots=True, eq=False)
class CommandRange:
    """Commands from one end to the other; zero is rest.

    Attributes:
        by_force: (n_a,) whether the effort is commanded and not the position.
        least: (n_a,) smallest commands, at most 0.
        most: (n_a,) largest commands.
    """

    by_force: Bools
    least: Array
    most: Array

    def command(self, shares: Array) -> Command:
        """The command at shares (n_a,) of −1 to 1: 0 is rest, 1 the largest, −1 the smallest."""
        value = np.where(shares > 0.0, shares * self.most, -shares * self.least)
        return Command.either(self.by_force, value, value)


def command_range(robot: Robot, report: Report = lambda share, what: None) -> CommandRange:
    """The range of each actuator alone, the others without effort.

    Positions are commanded where a motor holds its position and nothing opposes it: of drives, and of winches
    whose cables no other cable opposes. Efforts are commanded of chambers, of forces, and of cables that work
    against each other: wound to random lengths, these would crush the robot. Cables do so whose winches pay
    out beyond rest, and those that the pull of another one lengthens.
    """
    limits, laws = robot.limits, robot.actuators.laws
    W = static_compliance(robot, robot.rows(robot.rest(), contacts=False).actuators.dense())
    alone = ~laws.bilateral & (limits.position_min >= 0.0) & ~_opposed(W, ~laws.bilateral)
    by_force = ~alone & ~(laws.bilateral & ~laws.held_by_force)
    least = np.where(laws.bilateral, limits.position_min, 0.0)
    most = limits.position_max.copy()
    for i in np.flatnonzero(by_force):
        softness, number = float(W[i, i]), int(i)
        what = f"range of {robot.actuators.names[number]}"
        report(0.0, what)
        low, high = float(limits.effort_min[i]), float(limits.effort_max[i])
        least[i] = _effort(robot, number, low, float(limits.position_min[i]), softness)
        most[i] = _effort(robot, number, high, float(limits.position_max[i]), softness)
        report(1.0 / by_force.sum(), what)
    return CommandRange(by_force, np.minimum(least, 0.0), most)


def _opposed(W: Array, cables: Bools) -> Bools:
    """Which of some cables (n_a,) the pull of another lengthens, by W (n_a, n_a) of the actuators [m/N]."""
    scale = np.sqrt(np.diag(W))
    longer = -OPPOSES * np.outer(scale, scale) > W  # (n_a, n_a)
    found: Bools = cables & longer[:, cables].any(axis=1)
    return found


def _effort(robot: Robot, actuator: int, effort: float, position: float, softness: float) -> float:
    """The effort at a limit of the position, or the limit of the effort where that is met before."""
    if effort * position <= 0.0:
        return 0.0
    simulator = Simulator(robot, contact="none")
    bound = BEYOND * softness * effort  # no use in going farther than that, to first order
    positions, efforts = np.full(robot.n_a, np.nan), np.zeros(robot.n_a)
    positions[actuator] = bound if abs(bound) < abs(position) else position
    efforts[actuator] = np.nan
    settle_within_limits(simulator, positions, efforts, TOLERANCE * robot.size, ITERATIONS)
    found = float(simulator.effort[actuator])
    return found if abs(found) < abs(effort) else effort
