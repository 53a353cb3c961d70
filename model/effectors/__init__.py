"""Effectors of all kinds: their values and rows as functions of points that move with the body."""

from tauten.model.effectors.beam_effectors import BeamEffectors
from tauten.model.effectors.effector_set import EffectorSet, make_effector_set
from tauten.model.effectors.frame import FrameMeasure, frame_coefficients
from tauten.model.effectors.measure import (
    DistanceMeasure,
    LengthMeasure,
    Measure,
    PositionMeasure,
    VolumeMeasure,
)
from tauten.model.effectors.nodal import NodalEffectors, nodal_effectors

__all__ = [
    "BeamEffectors",
    "DistanceMeasure",
    "EffectorSet",
    "FrameMeasure",
    "LengthMeasure",
    "Measure",
    "NodalEffectors",
    "PositionMeasure",
    "VolumeMeasure",
    "frame_coefficients",
    "make_effector_set",
    "nodal_effectors",
]
