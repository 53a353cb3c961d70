"""The common part of all deformable bodies: material, sparse linear system, free vibration."""

from tauten.model.body.material import Material
from tauten.model.body.robot_base import RobotBase
from tauten.model.body.sparse_robot import SparseAssembled, SparseRobot
from tauten.model.body.vibration import natural_frequencies

__all__ = [
    "Material",
    "RobotBase",
    "SparseAssembled",
    "SparseRobot",
    "natural_frequencies",
]
