"""Reduced robots made of beams: modes of natural strains."""

from tauten.reduction.state.beams.reduction import ReducibleBeamRobot
from tauten.reduction.state.beams.robot import ReducedBeamRobot
from tauten.reduction.state.beams.tree import BeamTree, make_tree

__all__ = ["BeamTree", "ReducedBeamRobot", "ReducibleBeamRobot", "make_tree"]
