"""What the robot is: finite elements, cables, contacts, and the forward simulator."""

from tauten.model.config import RobotFileError
from tauten.model.load import load_robot
from tauten.model.mesh import MeshError
from tauten.model.robot import Robot, State
from tauten.model.simulator import Simulator
from tauten.model.tet_robot import TetRobot

__all__ = ["MeshError", "Robot", "RobotFileError", "Simulator", "State", "TetRobot", "load_robot"]
