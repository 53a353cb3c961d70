"""The real-time node: targets in, actuation out, at a fixed rate."""

from tauten.service.node.answers import QuestionAnswers
from tauten.service.node.clock import Beat, Clock, punctual_clock
from tauten.service.node.estimator import Estimator, make_estimator
from tauten.service.node.feedback import LARGEST, Feedback, ModelHistory, stable_gain
from tauten.service.node.inputs import MeasuredLoop
from tauten.service.node.limiter import ActuationLimiter
from tauten.service.node.loop import Action, ControlLoop
from tauten.service.node.model_watch import make_fall_back
from tauten.service.node.node import Node
from tauten.service.node.plausibility import MeasurementCheck
from tauten.service.node.serving import ServeSettings, serve
from tauten.service.node.state_machine import NodeState, Signals, commanded, judged, transition
from tauten.service.node.statistics import BOUNDS, Histogram, LoopStatistics

__all__ = [
    "Action",
    "ActuationLimiter",
    "BOUNDS",
    "Beat",
    "Clock",
    "ControlLoop",
    "Estimator",
    "Feedback",
    "Histogram",
    "LARGEST",
    "LoopStatistics",
    "MeasuredLoop",
    "MeasurementCheck",
    "ModelHistory",
    "Node",
    "NodeState",
    "QuestionAnswers",
    "ServeSettings",
    "Signals",
    "commanded",
    "judged",
    "make_estimator",
    "make_fall_back",
    "punctual_clock",
    "serve",
    "stable_gain",
    "transition",
]
