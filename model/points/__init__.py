"""Material points on bodies, and the rows of the cables through them."""

from tauten.model.points.attached_points import (
    AttachedPoints,
    attach_between,
    attach_to_nodes,
    join_attached_points,
)
from tauten.model.points.beam_cables import BeamCables, add_beam_cable_stiffness, make_beam_cables
from tauten.model.points.cable import Cable, CableSet, add_cable_stiffness, make_cables
from tauten.model.points.entries import (
    Entries,
    Placed,
    PlacedByMap,
    PlacedOnNodes,
    coordinates,
    placed_nodes,
)
from tauten.model.points.material_points import MaterialPoints, attach
from tauten.model.points.paths import Paths, Segments, blunted, make_paths, path_lengths

__all__ = [
    "AttachedPoints",
    "BeamCables",
    "Cable",
    "CableSet",
    "Entries",
    "MaterialPoints",
    "Paths",
    "Placed",
    "PlacedByMap",
    "PlacedOnNodes",
    "Segments",
    "add_beam_cable_stiffness",
    "add_cable_stiffness",
    "attach",
    "attach_between",
    "attach_to_nodes",
    "coordinates",
    "blunted",
    "join_attached_points",
    "make_beam_cables",
    "make_cables",
    "make_paths",
    "path_lengths",
    "placed_nodes",
]
