"""Where a quasi-static robot comes to in a period that moves it far: an equilibrium on its branch.

One linearisation does for what moves little. Where fast winches cross their range, a single one leads far
from any equilibrium, and the next ones start there: elements turn inside out, or the robot creeps towards its
equilibrium for so long that decisions hold back, because nothing comes of them.
"""

from __future__ import annotations

from tauten.model.numerics import FactorisationError
from tauten.model.robot import Robot
from tauten.model.signals import Command
from tauten.model.simulation.equilibrium import Ending
from tauten.model.simulation.search import EquilibriumSearch
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


def balanced(
    robot: Robot,
    space: ContactSpace,
    enrichment: Enrichment,
    state: State,
    forces: Forces,
    start: Command,
    command: Command,
) -> tuple[State, Forces, PredictedStep, bool]:
    """The equilibrium under a command, or as near to it as the search gets.

    Args:
        robot: its factorisation workspace is in use until the next call.
        space: basis of the contact forces.
        enrichment: when unit columns join.
        state: where the search starts.
        forces: constraint forces there.
        start: what the actuators have there.
        command: what they have at the end.

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
