"""The model of a robot: finite elements, cables, contacts, and the forward simulator."""

from tauten.model.actuation import ActuatorKind, Actuators, Quantity, Springs, cable_actuators
from tauten.model.command import Command
from tauten.model.command_range import CommandRange, command_range
from tauten.model.compliance import Compliance, row_compliance
from tauten.model.condensed_step import CondensedStep, Forces, condense_step, no_forces
from tauten.model.contact_space import ContactSpace, EmptySpace, ReducedContacts
from tauten.model.effector_layout import EffectorLayout, Goal, Pose, Target
from tauten.model.enrichment import (
    Enrichment,
    EnrichmentLoop,
    PredictedStep,
    contact_model,
    default_enrichment,
    worst_rows,
)
from tauten.model.equilibrium import Ending
from tauten.model.forward_step import ForwardStep, eliminate_rows, forward_step
from tauten.model.limits import Limits
from tauten.model.load.robot import load_robot
from tauten.model.mesh.tet_mesh import MeshError
from tauten.model.robot import Robot, RobotRows, State
from tauten.model.rows import ContactRows, EffectorRows, PairSlots, Rows
from tauten.model.schema.section import RobotFileError
from tauten.model.simulator import Simulator
from tauten.model.system import Integration, System, make_pattern
from tauten.model.tetra.robot import TetRobot

__all__ = [
    "ActuatorKind",
    "Actuators",
    "Command",
    "CommandRange",
    "Compliance",
    "CondensedStep",
    "ContactRows",
    "ContactSpace",
    "EffectorLayout",
    "EffectorRows",
    "EmptySpace",
    "Ending",
    "Enrichment",
    "EnrichmentLoop",
    "Forces",
    "ForwardStep",
    "Goal",
    "Integration",
    "Limits",
    "MeshError",
    "PairSlots",
    "Pose",
    "PredictedStep",
    "ReducedContacts",
    "Quantity",
    "Robot",
    "RobotFileError",
    "RobotRows",
    "Rows",
    "Simulator",
    "Springs",
    "State",
    "System",
    "Target",
    "TetRobot",
    "cable_actuators",
    "command_range",
    "condense_step",
    "contact_model",
    "default_enrichment",
    "eliminate_rows",
    "forward_step",
    "load_robot",
    "make_pattern",
    "no_forces",
    "row_compliance",
    "worst_rows",
]
