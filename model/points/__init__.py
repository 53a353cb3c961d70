"""Material points on bodies, and the rows of the cables through them."""

from tauten.model.points.attached_points import (
    AttachedPoints,
    Entries,
    attach_between,
    attach_to_nodes,
    join_attached_points,
)
from tauten.model.points.beam_cables import BeamCables, add_beam_cable_stiffness, make_beam_cables
from tauten.model.points.cable import (
    Cable,
    CableSet,
    add_cable_stiffness,
    blunted,
    cable_gradients,
    make_cables,
)
from tauten.model.points.material_points import MaterialPoints, attach

__all__ = [
    "AttachedPoints",
    "BeamCables",
    "Cable",
    "CableSet",
    "Entries",
    "MaterialPoints",
    "add_beam_cable_stiffness",
    "add_cable_stiffness",
    "attach",
    "attach_between",
    "attach_to_nodes",
    "blunted",
    "cable_gradients",
    "join_attached_points",
    "make_beam_cables",
    "make_cables",
]
