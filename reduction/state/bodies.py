"""Which bodies have state bases: the one table of kinds."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from tauten.model import Robot
from tauten.model.beams import BeamBody
from tauten.model.body import Body
from tauten.model.constraints import ConstrainedBody
from tauten.model.tetra import NodalBody
from tauten.reduction.reduced_body import Reducible, StateBasisError
from tauten.reduction.state.beams import ReducibleBeams
from tauten.reduction.state.tetra import reducible_constrained, reducible_nodes

REDUCIBLE: dict[type[Body], Callable[[Robot[Any]], Reducible]] = {
    NodalBody: reducible_nodes,
    ConstrainedBody: reducible_constrained,
    BeamBody: ReducibleBeams,
}


def reducible(robot: Robot) -> Reducible:
    """The robot as state reduction sees it.

    Raises:
        StateBasisError: its kind of body has no state bases.
    """
    if robot.body.part_robots:
        raise StateBasisError(
            f"robot {robot.name}: state bases belong to its parts: reduce the robot file of each part"
        )
    kind = type(robot.body)
    if kind not in REDUCIBLE:
        raise StateBasisError(
            f"robot {robot.name}: only full robots made of tetrahedra or of beams have state bases"
        )
    return REDUCIBLE[kind](robot)
