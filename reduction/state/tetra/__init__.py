"""Reduced robots made of tetrahedra: sampled integration points, directly in reduced coordinates."""

from tauten.reduction.state.tetra.driven import ReducedDrivenRobot, ReducibleDrivenRobot
from tauten.reduction.state.tetra.ecsw import contributions, sample_elements
from tauten.reduction.state.tetra.points import IntegrationPoints, integration_points
from tauten.reduction.state.tetra.robot import ReducedTetRobot, ReducibleTetRobot

__all__ = [
    "IntegrationPoints",
    "ReducedDrivenRobot",
    "ReducedTetRobot",
    "ReducibleDrivenRobot",
    "ReducibleTetRobot",
    "contributions",
    "integration_points",
    "sample_elements",
]
