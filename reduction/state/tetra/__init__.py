"""Reduced robots made of tetrahedra: sampled integration points, directly in reduced coordinates."""

from tauten.reduction.state.tetra.driven import ReducibleDrivenRobot
from tauten.reduction.state.tetra.ecsw import contributions, sample_elements
from tauten.reduction.state.tetra.points import integration_points
from tauten.reduction.state.tetra.robot import ReducibleTetRobot

__all__ = [
    "ReducibleDrivenRobot",
    "ReducibleTetRobot",
    "contributions",
    "integration_points",
    "sample_elements",
]
