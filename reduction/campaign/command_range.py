"""How far a robot's actuators can be commanded, one alone, before a limit of its position or effort is met.

Campaigns, paths and comparisons need loads that have an equilibrium. Limits in a robot file are those of the
motors; a soft robot often gives in long before.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tauten.model import Command, Robot, Simulator, row_compliance
from tauten.model.numerics import Array, Bools

BEYOND = 3.0  # how much farther than to first order an effort may lead
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
        nothing = np.full(len(value), np.nan)
        by_force = self.by_force
        return Command(np.where(by_force, nothing, value), np.where(by_force, value, nothing))


def command_range(robot: Robot) -> CommandRange:
    """The range of each actuator alone, the others without effort.

    Positions are commanded where a motor holds its position and nothing opposes it: of winches that do not
    pay out beyond rest, and of drives. Efforts are commanded of winches that do, because such cables work
    against each other, and of chambers and forces.

    Args:
        robot: the robot.
    """
    limits, laws = robot.limits, robot.actuators.laws
    winch = ~laws.bilateral & (limits.position_min >= 0.0)
    by_force = ~winch & ~(laws.bilateral & ~laws.held_by_force)
    least = np.where(laws.bilateral, limits.position_min, 0.0)
    most = limits.position_max.copy()
    for i in np.flatnonzero(by_force):
        least[i] = _effort(
            robot, int(i), float(limits.effort_min[i]), float(limits.position_min[i])
        )
        most[i] = _effort(robot, int(i), float(limits.effort_max[i]), float(limits.position_max[i]))
    return CommandRange(by_force, np.minimum(least, 0.0), most)


def _effort(robot: Robot, actuator: int, effort: float, position: float) -> float:
    """The effort at a limit of the position, or the limit of the effort where that is met before.

    Args:
        robot: the robot.
        actuator: its number.
        effort: limit of its effort.
        position: limit of its position, of the same sign.
    """
    if effort * position <= 0.0:
        return 0.0
    simulator = Simulator(robot, contact="none")
    static = replace(robot.integration, static=True)
    system = simulator.robot.linearise(robot.rest(), None, static)
    rows = robot.rows(robot.rest(), contacts=False).actuators
    softness = row_compliance(system, rows.dense(), rows.delta).W[actuator, actuator]
    bound = BEYOND * softness * effort  # no use in going farther than that, to first order
    positions, efforts = np.full(robot.n_a, np.nan), np.zeros(robot.n_a)
    positions[actuator] = bound if abs(bound) < abs(position) else position
    efforts[actuator] = np.nan
    simulator.settle(positions, efforts, TOLERANCE * robot.size, ITERATIONS)
    found = float(simulator.effort[actuator])
    return found if abs(found) < abs(effort) else effort
