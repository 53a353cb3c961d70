"""Reduced robots: state modes and sampled elements."""

from tauten.reduction.state.basis import (
    StateBasis,
    StateBasisError,
    StateOrigin,
    reducible_robot,
)
from tauten.reduction.state.ecsw import ElementSample, contributions, sample_elements
from tauten.reduction.state.model_error import TipCheck
from tauten.reduction.state.modes import enriched, pod, responses
from tauten.reduction.state.points import IntegrationPoints, integration_points
from tauten.reduction.state.reduce import (
    StateSettings,
    held_out_snapshots,
    n_elements,
    reduce_states,
)
from tauten.reduction.state.robot import ReducedRobot, reduced_robot

__all__ = [
    "ElementSample",
    "IntegrationPoints",
    "ReducedRobot",
    "StateBasis",
    "StateBasisError",
    "StateOrigin",
    "StateSettings",
    "TipCheck",
    "contributions",
    "enriched",
    "held_out_snapshots",
    "integration_points",
    "n_elements",
    "pod",
    "reduce_states",
    "reduced_robot",
    "reducible_robot",
    "responses",
    "sample_elements",
]
