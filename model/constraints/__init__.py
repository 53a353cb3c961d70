"""Rigid regions, drives and attachments by elimination: bodies in the coordinates that these leave."""

from tauten.model.constraints.body import ConstrainedBody
from tauten.model.constraints.coordinates import (
    CoordinateMap,
    make_coordinates,
    make_product_pattern,
)
from tauten.model.constraints.drums import Drums, supports_of
from tauten.model.constraints.followers import GluedNodes
from tauten.model.constraints.frames import (
    DriveRegion,
    Frames,
    PinnedRegion,
    RigidRegion,
    make_frames,
)
from tauten.model.constraints.joints import FrameJoints

__all__ = [
    "ConstrainedBody",
    "CoordinateMap",
    "DriveRegion",
    "Drums",
    "Frames",
    "GluedNodes",
    "FrameJoints",
    "PinnedRegion",
    "RigidRegion",
    "make_coordinates",
    "make_frames",
    "make_product_pattern",
    "supports_of",
]
