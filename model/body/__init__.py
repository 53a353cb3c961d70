"""What all kinds of deformable bodies have in common: material, sparse linear system."""

from tauten.model.body.material import Material
from tauten.model.body.sparse_robot import SparseRobot

__all__ = ["Material", "SparseRobot"]
