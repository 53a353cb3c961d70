"""Robots made of tetrahedra."""

from tauten.model.tetra.elements import assemble, lumped_mass, rest_gradients
from tauten.model.tetra.robot import Elements, TetRobot

__all__ = ["Elements", "TetRobot", "assemble", "lumped_mass", "rest_gradients"]
