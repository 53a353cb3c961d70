"""The mechanics of a robot: the interface of a body, sparse linear systems, free vibration."""

from tauten.model.body.body import RATES, Body, Turning
from tauten.model.body.sparse_body import SparseAssembled, SparseBody, has_lost_digits
from tauten.model.body.vibration import LIGHT_DAMPING, damping_ratios, natural_frequencies

__all__ = [
    "Body",
    "LIGHT_DAMPING",
    "RATES",
    "SparseAssembled",
    "SparseBody",
    "Turning",
    "damping_ratios",
    "has_lost_digits",
    "natural_frequencies",
]
