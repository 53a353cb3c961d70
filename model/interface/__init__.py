"""What a robot takes and gives: actuators with limits and commands, effectors with goals."""

from tauten.model.interface.actuation import (
    ActuatorKind,
    Actuators,
    Quantity,
    actuators_of,
    cable_actuators,
)
from tauten.model.interface.command import Command
from tauten.model.interface.effector_layout import (
    ROWS,
    UNIT_LENGTH,
    VALUES,
    EffectorGoal,
    EffectorLayout,
    Pose,
    Target,
    effector_layout,
    point_layout,
)
from tauten.model.interface.laws import Laws
from tauten.model.interface.limits import Limits, limits_of

__all__ = [
    "ActuatorKind",
    "Actuators",
    "Command",
    "EffectorGoal",
    "EffectorLayout",
    "Laws",
    "Limits",
    "Pose",
    "Quantity",
    "ROWS",
    "Target",
    "UNIT_LENGTH",
    "VALUES",
    "actuators_of",
    "cable_actuators",
    "effector_layout",
    "limits_of",
    "point_layout",
]
