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

__all__ = [
    "Floats",
    "Geometry",
    "NO_CONTACTS",
    "PushingContacts",
    "Robot",
    "RobotNames",
    "SkinMesh",
    "names_of",
    "skin_of",
]
