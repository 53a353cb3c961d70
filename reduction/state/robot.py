"""The reduced robot of a state basis."""

from __future__ import annotations

from tauten.model import Robot
from tauten.reduction.reduced_body import ReducedBody
from tauten.reduction.state.basis import StateBasis
from tauten.reduction.state.bodies import reducible


def reduced_robot(robot: Robot, states: StateBasis) -> Robot[ReducedBody]:
    """The robot in the coordinates of a state basis.

    Raises:
        StateBasisError: the basis was made for another robot, or this one has no state bases.
    """
    states.check_robot(robot)
    return reducible(robot).reduced(states.Phi, states.elements, states.weights)
