"""Reduced robots made of tetrahedra: sampled integration points, directly in reduced coordinates."""

from tauten.reduction.state.tetra.ecsw import contributions, sample_elements
from tauten.reduction.state.tetra.points import integration_points
from tauten.reduction.state.tetra.reducible import (
    reducible_constrained,
    reducible_nodes,
)

__all__ = [
    "contributions",
    "integration_points",
    "reducible_constrained",
    "reducible_nodes",
    "sample_elements",
]
