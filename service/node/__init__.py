"""The real-time node: targets in, actuation out, at a fixed rate."""

from tauten.service.node.clock import Clock, punctual_clock
from tauten.service.node.estimator import Estimator, own_estimator
from tauten.service.node.feedback import LARGEST, Feedback
from tauten.service.node.loop import Action, ControlLoop
from tauten.service.node.node import Node
from tauten.service.node.serving import ServeSettings, serve
from tauten.service.node.state_machine import Signals

__all__ = [
    "Action",
    "Clock",
    "ControlLoop",
    "Estimator",
    "Feedback",
    "LARGEST",
    "Node",
    "ServeSettings",
    "Signals",
    "own_estimator",
    "punctual_clock",
    "serve",
]
