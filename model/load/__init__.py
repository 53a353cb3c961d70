"""From a robot file to a robot."""

from tauten.model.load.beams import groups
from tauten.model.load.robot import build_robot, load_robot, make_robot, robot_path

__all__ = ["build_robot", "groups", "load_robot", "make_robot", "robot_path"]
