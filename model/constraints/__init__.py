"""Rigid regions, drives and attachments by elimination: robots in the coordinates that these leave."""

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
from tauten.model.constraints.robot import ConstrainedRobot

__all__ = [
    "ConstrainedRobot",
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
