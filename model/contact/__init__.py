"""Contact: from surfaces to gap rows."""

from tauten.model.contact.broad_phase import BLOCK, blocks_of
from tauten.model.contact.detection import ContactSet
from tauten.model.contact.gap_rows import contact_rows
from tauten.model.contact.holes import holes_before_obstacles, holes_between
from tauten.model.contact.mesh_shape import MeshShape, enclosed, heights_of_file, mesh_of_file
from tauten.model.contact.obstacle import (
    Obstacle,
    ObstaclePath,
    ObstaclePose,
    ObstaclePoses,
    PoseStream,
    pose_at,
    velocity_between,
)
from tauten.model.contact.outlines import RodOutline, across
from tauten.model.contact.pair import (
    ContactPair,
    ForceBounds,
    LargestSum,
    largest_sums,
    loose_bodies,
)
from tauten.model.contact.self_contact import (
    ALARM_EDGES,
    EDGES_AWAY,
    WALL_ALARMS,
    mean_edge,
    neighbours_at_rest,
)
from tauten.model.contact.shapes import SHAPES, PlaneShape, Shape, distances_fault
from tauten.model.contact.sides import apart
from tauten.model.contact.triangle_tree import box_tree

__all__ = [
    "ALARM_EDGES",
    "BLOCK",
    "ContactPair",
    "ContactSet",
    "ForceBounds",
    "LargestSum",
    "EDGES_AWAY",
    "MeshShape",
    "Obstacle",
    "ObstaclePath",
    "ObstaclePose",
    "ObstaclePoses",
    "PlaneShape",
    "PoseStream",
    "RodOutline",
    "SHAPES",
    "Shape",
    "WALL_ALARMS",
    "across",
    "apart",
    "blocks_of",
    "box_tree",
    "contact_rows",
    "distances_fault",
    "enclosed",
    "heights_of_file",
    "holes_before_obstacles",
    "holes_between",
    "largest_sums",
    "loose_bodies",
    "mean_edge",
    "mesh_of_file",
    "neighbours_at_rest",
    "pose_at",
    "velocity_between",
]
