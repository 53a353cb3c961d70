"""What the robot is: finite elements, cables, contacts, and the forward simulator."""

from tauten.model.compliance import Compliance, extended, row_compliance
from tauten.model.contact_space import ContactSpace, EmptySpace, ReducedContacts
from tauten.model.forward_step import (
    Enrichment,
    Forces,
    contact_model,
    default_enrichment,
    no_forces,
    unit_rows,
    worst_rows,
)
from tauten.model.limits import Limits
from tauten.model.load.robot import load_robot
from tauten.model.mesh.tet_mesh import MeshError
from tauten.model.robot import Robot, RobotRows, State
from tauten.model.rows import ContactRows, PairSlots, Rows
from tauten.model.schema.robot_file import RobotFileError
from tauten.model.simulator import Simulator
from tauten.model.system import Integration, System, make_pattern
from tauten.model.tetra.robot import TetRobot

__all__ = [
    "Compliance",
    "ContactRows",
    "ContactSpace",
    "EmptySpace",
    "Enrichment",
    "Forces",
    "Integration",
    "Limits",
    "MeshError",
    "PairSlots",
    "ReducedContacts",
    "Robot",
    "RobotFileError",
    "RobotRows",
    "Rows",
    "Simulator",
    "State",
    "System",
    "TetRobot",
    "contact_model",
    "default_enrichment",
    "extended",
    "load_robot",
    "make_pattern",
    "no_forces",
    "row_compliance",
    "unit_rows",
    "worst_rows",
]
