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
    body = robot.raw if isinstance(robot, ConstrainedRobot) else robot
    if isinstance(body, TetRobot) and body.viscosity is not None:
        raise StateBasisError(
            f"robot {robot.name}: viscous materials have no state bases; leave out material.viscosity, "
            "or use the full model"
        )
    if (
        isinstance(robot, ConstrainedRobot)
        and robot.joints is not None
        and len(robot.joints.nodes) > 0
    ):
        raise StateBasisError(
            f"robot {robot.name}: robots with beams beside bodies of tetrahedra have no state bases; use "
            "the full model"
        )
    if isinstance(robot, TetRobot | ConstrainedRobot):
        return ReducibleTetRobot(robot)
    if isinstance(robot, BeamRobot):
        return ReducibleBeamRobot(robot)
    raise StateBasisError(
        f"robot {robot.name}: only full robots made of tetrahedra or of beams have state bases"
    )
