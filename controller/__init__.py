"""Inverse control: from a target to cable tensions, one decision a time step."""

from tauten.controller.compliance import Response
from tauten.controller.controller import NOTHING, Actuation, Controller
from tauten.controller.inverse import energy_scale, inverse_problem, shut
from tauten.controller.qpcc.solution import Certificate, Status
from tauten.controller.step import advance, decide, forces_of, predicted_gaps, prepare, warm_piece

__all__ = [
    "Actuation",
    "Certificate",
    "Controller",
    "NOTHING",
    "Response",
    "Status",
    "advance",
    "decide",
    "energy_scale",
    "forces_of",
    "inverse_problem",
    "predicted_gaps",
    "prepare",
    "shut",
    "warm_piece",
]
