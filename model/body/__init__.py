"""The common part of all deformable bodies: material and sparse linear system."""

from tauten.model.body.material import Material
from tauten.model.body.sparse_robot import SparseRobot

__all__ = ["Material", "SparseRobot"]
