"""Material points on bodies, and the rows of the cables through them."""

from tauten.model.points.attached_points import (
    AttachedPoints,
    PlacedOnBeams,
    PoseMotion,
    attach_between,
    attach_to_nodes,
    join_attached_points,
    no_attached_points,
)
from tauten.model.points.beam_cables import add_beam_cable_stiffness, add_lever_stiffness
from tauten.model.points.cable import add_cable_stiffness, segment_nodes, segment_weights
from tauten.model.points.entries import (
    Entries,
    Motion,
    OuterForces,
    Placed,
    dense_units,
    mapped_rows,
    sparse_units,
)
from tauten.model.points.material_points import attach
from tauten.model.points.nodes import (
    CsrArrays,
    MeanPoints,
    NodeMotion,
    NodePoints,
    combinations,
    mean_points,
    points_at,
)
from tauten.model.points.paths import Paths, Segments, blunted, make_paths, path_lengths

__all__ = [
    "AttachedPoints",
    "Entries",
    "MeanPoints",
    "Motion",
    "CsrArrays",
    "NodeMotion",
    "NodePoints",
    "OuterForces",
    "Paths",
    "Placed",
    "PlacedOnBeams",
    "PoseMotion",
    "Segments",
    "add_beam_cable_stiffness",
    "add_lever_stiffness",
    "add_cable_stiffness",
    "attach",
    "attach_between",
    "attach_to_nodes",
    "blunted",
    "combinations",
    "dense_units",
    "join_attached_points",
    "make_paths",
    "mapped_rows",
    "mean_points",
    "no_attached_points",
    "path_lengths",
    "points_at",
    "segment_nodes",
    "segment_weights",
    "sparse_units",
]
