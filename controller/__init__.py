"""Inverse control: from a target to cable tensions, one decision a time step."""

from tauten.controller.actuation import NO_CERTIFICATE, Actuation
from tauten.controller.certificates import hold_certificate
from tauten.controller.controller import Controller
from tauten.controller.inverse import closed_compliance, energy_scale, inverse_problem
from tauten.controller.locks import LockError
from tauten.controller.plan import DecideSettings, Prepared
from tauten.controller.qpcc.solution import Certificate, Status
from tauten.controller.settings import (
    ControllerSettings,
    controller_settings,
    load_controller_settings,
)
from tauten.controller.step import Decision, Horizon, decide, hold, prepare, substeps_of

__all__ = [
    "Actuation",
    "Certificate",
    "Controller",
    "ControllerSettings",
    "DecideSettings",
    "Decision",
    "Horizon",
    "LockError",
    "NO_CERTIFICATE",
    "Prepared",
    "Status",
    "closed_compliance",
    "controller_settings",
    "decide",
    "energy_scale",
    "hold",
    "hold_certificate",
    "inverse_problem",
    "load_controller_settings",
    "prepare",
    "substeps_of",
]
