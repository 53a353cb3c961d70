"""Actuators of robots: rows (H, δ) with the conjugate effort λ, and the curvature that efforts add."""

from tauten.model.actuators.actuator_set import ActuatorParts, ActuatorSet, place_actuators
from tauten.model.actuators.beam_actuators import BeamActuators
from tauten.model.actuators.chamber import ChamberSurface, volumes
from tauten.model.actuators.coupling import Coupling, coupling_of, motor_rows
from tauten.model.actuators.enclosure import (
    ChamberError,
    cavity_around,
    cavity_nearest,
    chamber_surface,
    enclosed_volume,
    inside_out,
)
from tauten.model.actuators.force import PointForce

__all__ = [
    "ActuatorParts",
    "ActuatorSet",
    "BeamActuators",
    "ChamberError",
    "ChamberSurface",
    "Coupling",
    "PointForce",
    "cavity_around",
    "cavity_nearest",
    "chamber_surface",
    "coupling_of",
    "motor_rows",
    "enclosed_volume",
    "inside_out",
    "place_actuators",
    "volumes",
]
