"""Which robots have state bases."""

from __future__ import annotations

from tauten.model import Robot, TetRobot
from tauten.model.beams import BeamRobot
from tauten.model.constraints import ConstrainedRobot
from tauten.reduction.reduced_robot import Reducible, StateBasisError
from tauten.reduction.state.beams import ReducibleBeamRobot
from tauten.reduction.state.tetra import ReducibleTetRobot


def reducible(robot: Robot) -> Reducible:
    """The robot as state reduction sees it.

    Raises:
        StateBasisError: its kind of body has no state bases.
    """
    if isinstance(robot, ConstrainedRobot):
        raise StateBasisError(
            f"robot {robot.name}: robots with drives, rigid regions, beams or attachments have no state "
            "bases; use the full model"
        )
    if isinstance(robot, TetRobot) and robot.viscosity is not None:
        raise StateBasisError(
            f"robot {robot.name}: viscous materials have no state bases; leave out material.viscosity, "
            "or use the full model"
        )
    if isinstance(robot, TetRobot):
        if robot.viscosity is not None:
            raise StateBasisError(
                f"robot {robot.name}: viscous materials have no state bases; leave out material.viscosity, "
                "or use the full model"
            )
        return ReducibleTetRobot(robot)
    if isinstance(robot, BeamRobot):
        return ReducibleBeamRobot(robot)
    raise StateBasisError(
        f"robot {robot.name}: only full robots made of tetrahedra or of beams have state bases"
    )
