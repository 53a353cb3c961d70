"""What goes in and out of a robot: commands, limits and laws of actuators, goals of effectors."""

from tauten.model.signals.actuation import (
    ActuatorKind,
    Actuators,
    Quantity,
    actuators_of,
    cable_actuators,
)
from tauten.model.signals.command import Command
from tauten.model.signals.effector_layout import (
    ROWS,
    UNIT_LENGTH,
    EffectorLayout,
    effector_layout,
)
from tauten.model.signals.laws import Laws, Springs
from tauten.model.signals.limits import Limits, coupled_range, limits_of
from tauten.model.signals.targets import VALUES, EffectorGoal, Pose, Target

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
    "Springs",
    "ROWS",
    "Target",
    "UNIT_LENGTH",
    "VALUES",
    "actuators_of",
    "coupled_range",
    "cable_actuators",
    "effector_layout",
    "limits_of",
]
