"""The model of a robot: finite elements, cables, contacts, and the forward simulator."""

from tauten.model.compliance import Compliance, row_compliance
from tauten.model.condensed_step import (
    CondensedStep,
    Forces,
    condense_step,
    condensed,
    no_forces,
    recondensed,
)
from tauten.model.contact_space import ContactSpace, EmptySpace, ReducedContacts
from tauten.model.contacts import Contacts
from tauten.model.enrichment import (
    Enrichment,
    EnrichmentLoop,
    PredictedStep,
    contact_model,
    default_enrichment,
    worst_rows,
)
from tauten.model.forward_step import ForwardStep, eliminate_rows, forward_step
from tauten.model.interface import (
    ROWS,
    UNIT_LENGTH,
    VALUES,
    ActuatorKind,
    Actuators,
    Command,
    EffectorGoal,
    EffectorLayout,
    Limits,
    Pose,
    Quantity,
    Target,
    cable_actuators,
    point_layout,
)
from tauten.model.layout import Layout, row_layout
from tauten.model.load.robot import load_robot
from tauten.model.mesh.tet_mesh import MeshError
from tauten.model.robot import Assembled, Robot, RobotRows, State
from tauten.model.rows import ChainedRows, ContactRows, EffectorRows, PairSlots, Rows
from tauten.model.schema.section import RobotFileError
from tauten.model.simulation import Ending, Report, Simulator, Travel, travel
from tauten.model.skin import (
    NO_CONTACTS,
    Floats,
    Geometry,
    PushingContacts,
    SkinMesh,
    skin_of,
)
from tauten.model.sorted_rows import sorted_rows
from tauten.model.system import Integration, System, make_pattern
from tauten.model.tetra.robot import TetRobot
from tauten.model.threads import one_blas_thread

__all__ = [
    "ActuatorKind",
    "Actuators",
    "Assembled",
    "ChainedRows",
    "Command",
    "Compliance",
    "CondensedStep",
    "ContactRows",
    "ContactSpace",
    "EffectorGoal",
    "Contacts",
    "PushingContacts",
    "EffectorLayout",
    "EffectorRows",
    "EmptySpace",
    "Ending",
    "Enrichment",
    "EnrichmentLoop",
    "Floats",
    "Forces",
    "ForwardStep",
    "Geometry",
    "Integration",
    "Layout",
    "Limits",
    "MeshError",
    "NO_CONTACTS",
    "PairSlots",
    "Pose",
    "PredictedStep",
    "ROWS",
    "Quantity",
    "ReducedContacts",
    "Report",
    "Robot",
    "RobotFileError",
    "RobotRows",
    "Rows",
    "Simulator",
    "SkinMesh",
    "State",
    "System",
    "Target",
    "TetRobot",
    "Travel",
    "UNIT_LENGTH",
    "VALUES",
    "cable_actuators",
    "condense_step",
    "condensed",
    "contact_model",
    "default_enrichment",
    "eliminate_rows",
    "forward_step",
    "load_robot",
    "make_pattern",
    "no_forces",
    "one_blas_thread",
    "point_layout",
    "recondensed",
    "row_compliance",
    "row_layout",
    "skin_of",
    "sorted_rows",
    "travel",
    "worst_rows",
]
