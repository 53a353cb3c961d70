"""The simulated robot, streams of targets, and the demo."""

from tauten.service.plant.demo import (
    FIGURE,
    LOG,
    REPORT,
    TARGETS,
    DemoResult,
    DemoSettings,
    run_demo,
)
from tauten.service.plant.drives import DrivenRobot, own_steps
from tauten.service.plant.paths import (
    SHAPES,
    PathSettings,
    Plane,
    bending_command,
    directions,
    make_path,
)
from tauten.service.plant.plant import Drive, PlantSettings, plant_robot, simulate, warm_plant
from tauten.service.plant.processes import Child, DemoError, child, free_ports
from tauten.service.plant.receiver import find_receiver, receiver_path
from tauten.service.plant.streaming import StreamSettings, stream
from tauten.service.plant.waypoints import (
    COLUMNS,
    PathError,
    TargetPath,
    path_text,
    save_path,
    without_sign_changes,
)

__all__ = [
    "plant_robot",
    "COLUMNS",
    "Child",
    "DemoError",
    "DemoResult",
    "DemoSettings",
    "Drive",
    "DrivenRobot",
    "FIGURE",
    "LOG",
    "PathError",
    "PathSettings",
    "Plane",
    "PlantSettings",
    "REPORT",
    "SHAPES",
    "StreamSettings",
    "TARGETS",
    "TargetPath",
    "bending_command",
    "child",
    "directions",
    "find_receiver",
    "free_ports",
    "make_path",
    "own_steps",
    "receiver_path",
    "run_demo",
    "path_text",
    "save_path",
    "without_sign_changes",
    "simulate",
    "stream",
    "warm_plant",
]
