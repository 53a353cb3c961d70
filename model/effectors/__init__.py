"""Effectors of all kinds: their values and rows as functions of points that move with the body."""

from tauten.model.effectors.effectors import Effectors
from tauten.model.effectors.frame import FrameMeasure, frame_coefficients
from tauten.model.effectors.measure import (
    DistanceMeasure,
    LengthMeasure,
    Measure,
    Measurement,
    PositionMeasure,
    VolumeMeasure,
    measurement_fault,
)

__all__ = [
    "DistanceMeasure",
    "Effectors",
    "FrameMeasure",
    "LengthMeasure",
    "Measure",
    "Measurement",
    "PositionMeasure",
    "VolumeMeasure",
    "frame_coefficients",
    "measurement_fault",
]
