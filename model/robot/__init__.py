"""The robot that a step uses, and what of it is drawn."""

from tauten.model.robot.clusters import Cluster, Clusters, clusters_of
from tauten.model.robot.robot import Robot
from tauten.model.robot.skin import (
    NO_CONTACTS,
    Floats,
    Geometry,
    ObstacleOutline,
    PushingContacts,
    SkinMesh,
    contact_wrenches,
    held_vertices,
    obstacles_of,
    skin_of,
    touched_names,
)

__all__ = [
    "Cluster",
    "Clusters",
    "clusters_of",
    "ObstacleOutline",
    "Floats",
    "Geometry",
    "NO_CONTACTS",
    "PushingContacts",
    "Robot",
    "SkinMesh",
    "held_vertices",
    "contact_wrenches",
    "touched_names",
    "obstacles_of",
    "skin_of",
]
