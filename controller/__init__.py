"""Inverse control: from a target to cable tensions, one decision a time step."""

from tauten.controller.controller import Actuation, Controller
from tauten.controller.solution import Certificate, Status

__all__ = ["Actuation", "Certificate", "Controller", "Status"]
