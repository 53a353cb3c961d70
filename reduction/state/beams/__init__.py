"""Reduced robots made of beams: modes of natural strains."""

from tauten.reduction.state.beams.reduction import ReducibleBeamRobot
from tauten.reduction.state.beams.robot import ReducedBeamRobot

__all__ = ["ReducedBeamRobot", "ReducibleBeamRobot"]
