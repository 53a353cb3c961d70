"""What the robot is: finite elements, cables, contacts, and the forward simulator."""

from tauten.model.config import RobotFileError
from tauten.model.load import load_robot
from tauten.model.mesh import MeshError
from tauten.model.robot import Robot
from tauten.model.simulator import Simulator

__all__ = ["MeshError", "Robot", "RobotFileError", "Simulator", "load_robot"]
