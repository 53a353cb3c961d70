"""The real-time node: targets in, actuation out, at a fixed rate."""

from tauten.service.node.clock import Beat, Clock, punctual_clock
from tauten.service.node.fall_back import make_fall_back
from tauten.service.node.feedback import LARGEST, Feedback
from tauten.service.node.histogram import BOUNDS, Histogram
from tauten.service.node.limiter import ActuationLimiter
from tauten.service.node.loop import Action, ControlLoop
from tauten.service.node.node import Node
from tauten.service.node.serving import ServeSettings, serve
from tauten.service.node.state_machine import NodeState, Signals, commanded, judged, transition

__all__ = [
    "Action",
    "ActuationLimiter",
    "BOUNDS",
    "Beat",
    "Clock",
    "ControlLoop",
    "Feedback",
    "Histogram",
    "LARGEST",
    "Node",
    "NodeState",
    "ServeSettings",
    "Signals",
    "commanded",
    "judged",
    "make_fall_back",
    "punctual_clock",
    "serve",
    "transition",
]
