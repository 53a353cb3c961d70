"""Where a quasi-static robot comes to in a period that moves it far: an equilibrium on its branch.

One linearisation does for what moves little. Where fast winches cross their range, a single one leads far
from any equilibrium, and the next ones start there: elements turn inside out, or the robot creeps towards its
equilibrium for so long that decisions hold back, because nothing comes of them.
"""

from __future__ import annotations

import numpy as np

from tauten.model.numerics import Array, FactorisationError
from tauten.model.robot import Robot
from tauten.model.signals import Command
from tauten.model.simulation.equilibrium import Ending
from tauten.model.simulation.search import REACH, EquilibriumSearch
from tauten.model.state import State
from tauten.model.step import ContactSpace, Enrichment, Forces, PredictedStep

FAR = 2e-2  # of the size of the robot's largest part; less than this in a period is little
TOLERANCE = 1e-6  # of that size
ITERATIONS = 60  # linearised steps at most


def moves_far(robot: Robot, taken: PredictedStep) -> bool:
    """Whether a quasi-static step moves a robot farther than its linearisation reaches.

    What moves by its inertia, in quasi-static steps too, comes to no equilibrium in a period.
    """
    if not robot.integration.static:
        return False
    system = taken.step.system
    moved = robot.displacement(taken.step.state, system.h * (system.v + taken.dv))
    return not (moved <= FAR * robot.part_size or robot.floats)


def within_reach(robot: Robot, state: State, dv: Array, h: float) -> tuple[Array, float]:
    """A change of the velocity (n,) in a step of dynamic parts, and the largest displacement by it [m].

    Quasi-static parts beside these take a step of Newton's method in it, here no farther than in a search
    for an equilibrium: longer ones led to and fro.

    Args:
        robot: the robot.
        state: where the step is linearised.
        dv: (n,) change in the step [m/s].
        h: its length [s].
    """
    found, body = dv.copy(), robot.body
    for name, part in zip(body.part_names, body.part_robots, strict=True):
        if part.integration.static and not part.floats:
            own, span = np.zeros_like(dv), body.unknowns_of(name)
            own[span] = h * dv[span]
            way, most = body.displacement(state, own), REACH * part.size
            found[span] *= most / max(way, most)
    return found, body.displacement(state, h * found)


def balanced(
    robot: Robot,
    space: ContactSpace,
    enrichment: Enrichment,
    state: State,
    forces: Forces,
    start: Command,
    command: Command,
) -> tuple[State, Forces, PredictedStep, bool]:
    """The equilibrium under a command, or as near to it as the search from a state, forces and command gets.

    The factorisation workspace of the robot is in use until the next call.

    Returns:
        The state, the constraint forces there, the last step of the search, and whether it has settled.

    Raises:
        FactorisationError: the state has diverged.
    """
    search = EquilibriumSearch(robot.with_obstacles(robot.obstacles.still()), space, enrichment)
    tolerance = TOLERANCE * robot.part_size
    found = search.run(state, forces, command, start, tolerance, ITERATIONS)
    if found.last is None or found.report.ending is Ending.NOT_FINITE:
        raise FactorisationError("no equilibrium was found: the state has diverged")
    return found.state, found.forces, found.last, found.report.converged
