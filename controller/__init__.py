"""Inverse control: from a target to cable tensions, one decision a time step."""

from tauten.controller.actuation import NO_CERTIFICATE, Actuation
from tauten.controller.bases import beside, load_contact, part_files
from tauten.controller.certificates import hold_certificate
from tauten.controller.controller import Controller
from tauten.controller.loading import ControllerSetup, Order, controller_setup
from tauten.controller.planning import (
    DecideSettings,
    Horizon,
    LockError,
    Prepared,
    closed_compliance,
    energy_scale,
    inverse_problem,
)
from tauten.controller.qpcc.solution import Certificate, Status
from tauten.controller.settings import (
    ControllerSettings,
    ControllerTable,
    ModelSettings,
    load_controller_settings,
    load_model_settings,
    substeps_of,
)
from tauten.controller.starting import start_at_rest, target_beside, warm_controller
from tauten.controller.step import Decision, decide, hold, prepare

__all__ = [
    "Actuation",
    "Certificate",
    "Controller",
    "ControllerSettings",
    "ControllerTable",
    "ControllerSetup",
    "DecideSettings",
    "Decision",
    "Horizon",
    "LockError",
    "ModelSettings",
    "NO_CERTIFICATE",
    "Order",
    "Prepared",
    "Status",
    "beside",
    "closed_compliance",
    "controller_setup",
    "decide",
    "energy_scale",
    "hold",
    "hold_certificate",
    "inverse_problem",
    "load_contact",
    "load_controller_settings",
    "load_model_settings",
    "part_files",
    "prepare",
    "start_at_rest",
    "target_beside",
    "substeps_of",
    "warm_controller",
]
