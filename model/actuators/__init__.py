"""Actuators of robots: rows (H, δ) with the conjugate effort λ, and the curvature that efforts add."""

from tauten.model.actuators.actuator_set import ActuatorRows, ActuatorSet, Loads
from tauten.model.actuators.chamber import ChamberSurface, bulging, make_chambers, volumes
from tauten.model.actuators.coupling import Coupling, coupling_of
from tauten.model.actuators.curvature import NodalCurvature, coupled_nodes, nodal_curvature
from tauten.model.actuators.drive import DriveSet, no_drives
from tauten.model.actuators.enclosure import (
    ChamberError,
    cavities,
    cavity_around,
    cavity_nearest,
    chamber_surface,
    connected_parts,
    enclosed_volume,
    inside_out,
    open_edges,
    winding,
)
from tauten.model.actuators.force import ForceSet, make_forces
from tauten.model.actuators.transmission import (
    Transmission,
    TransmissionSet,
    Transmitted,
    make_transmissions,
    second_derivative,
    transmitted_fault,
)

__all__ = [
    "ActuatorRows",
    "ActuatorSet",
    "ChamberError",
    "ChamberSurface",
    "Coupling",
    "DriveSet",
    "ForceSet",
    "Loads",
    "Transmission",
    "TransmissionSet",
    "Transmitted",
    "NodalCurvature",
    "cavities",
    "bulging",
    "cavity_around",
    "cavity_nearest",
    "chamber_surface",
    "connected_parts",
    "coupled_nodes",
    "coupling_of",
    "enclosed_volume",
    "inside_out",
    "make_chambers",
    "make_forces",
    "make_transmissions",
    "no_drives",
    "nodal_curvature",
    "open_edges",
    "second_derivative",
    "transmitted_fault",
    "volumes",
    "winding",
]
