"""The mass of a robot's nodes that are not fixed, by which payloads are chosen."""

from __future__ import annotations

from tauten.model import Robot, TetRobot
from tauten.model.beams import BeamRobot
from tauten.model.constraints import ConstrainedRobot


def moving_mass(robot: Robot) -> float:
    """Mass of all nodes that are not fixed [kg].

    Raises:
        TypeError: the robot is not a full one.
    """
    body = robot.raw if isinstance(robot, ConstrainedRobot) else robot
    if isinstance(body, BeamRobot):
        return float(body.mass[::6].sum())
    if isinstance(body, TetRobot):
        return float(body.mass[::3].sum())
    raise TypeError(f"robot {robot.name} is a {type(robot).__name__}: expected is a full robot")
