"""What a viewer shows, and where it comes from: a simulation, a served robot, a log."""

from tauten.service.frames.frame import RobotLook, ViewFrame
from tauten.service.frames.history import FrameHistory
from tauten.service.frames.missed import RESTED, Miss, missed
from tauten.service.frames.reach import ReachSearch, ReachSet
from tauten.service.frames.recorded import RecordedRobot
from tauten.service.frames.served import ServedRobot
from tauten.service.frames.simulated import SimulatedRobot
from tauten.service.frames.targets import ScalarScale, TargetStore, scalar_scale
from tauten.service.frames.waypoints import WaypointList

__all__ = [
    "FrameHistory",
    "Miss",
    "ReachSearch",
    "ReachSet",
    "RecordedRobot",
    "RobotLook",
    "ScalarScale",
    "ServedRobot",
    "SimulatedRobot",
    "TargetStore",
    "ViewFrame",
    "RESTED",
    "WaypointList",
    "scalar_scale",
    "missed",
]
