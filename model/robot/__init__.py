"""The robot that a step uses, and what of it is drawn."""

from tauten.model.robot.names import RobotNames, names_of
from tauten.model.robot.robot import Robot
from tauten.model.robot.skin import (
    NO_CONTACTS,
    Floats,
    Geometry,
    PushingContacts,
    SkinMesh,
    skin_of,
)
from tauten.model.robot.surroundings import held_vertices, obstacle_wrenches, obstacles_of

__all__ = [
    "Floats",
    "Geometry",
    "NO_CONTACTS",
    "PushingContacts",
    "Robot",
    "RobotNames",
    "SkinMesh",
    "held_vertices",
    "names_of",
    "obstacle_wrenches",
    "obstacles_of",
    "skin_of",
]
