"""Reduced robots: state modes and sampled elements."""

from tauten.reduction.reduced_body import ElementSample, ReducedBody, StateBasisError
from tauten.reduction.state.attempts import step_times
from tauten.reduction.state.basis import SUFFIX, StateBasis, StateOrigin, reduced_robot
from tauten.reduction.state.bodies import reducible
from tauten.reduction.state.held_out import held_out_snapshots
from tauten.reduction.state.model_error import TipCheck
from tauten.reduction.state.modes import enriched, pod, responses
from tauten.reduction.state.parts import ReducedParts, reduced_parts
from tauten.reduction.state.reduce import (
    Narrower,
    StateSettings,
    reduce_states,
)

__all__ = [
    "ElementSample",
    "Narrower",
    "ReducedBody",
    "ReducedParts",
    "SUFFIX",
    "StateBasis",
    "StateBasisError",
    "StateOrigin",
    "StateSettings",
    "TipCheck",
    "enriched",
    "held_out_snapshots",
    "pod",
    "reduce_states",
    "reduced_parts",
    "reduced_robot",
    "reducible",
    "responses",
    "step_times",
]
