"""Reduced robots: state modes and sampled elements."""

from tauten.reduction.state.basis import StateBasis, StateBasisError, StateOrigin
from tauten.reduction.state.ecsw import ElementSample, contributions, sample_elements
from tauten.reduction.state.model_error import TipCheck
from tauten.reduction.state.modes import enriched, pod, responses
from tauten.reduction.state.reduce import StateSettings, held_out_snapshots, reduce_states
from tauten.reduction.state.robot import ReducedRobot, reduced_robot

__all__ = [
    "ElementSample",
    "ReducedRobot",
    "StateBasis",
    "StateBasisError",
    "StateOrigin",
    "StateSettings",
    "TipCheck",
    "contributions",
    "enriched",
    "held_out_snapshots",
    "pod",
    "reduce_states",
    "reduced_robot",
    "responses",
    "sample_elements",
]
