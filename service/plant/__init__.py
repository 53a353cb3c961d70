"""The simulated robot, streams of targets, and the demo."""

from tauten.service.plant.demo import FIGURE, LOG, DemoResult, DemoSettings, run_demo
from tauten.service.plant.drives import Drive, DrivenRobot, own_steps
from tauten.service.plant.paths import PathSettings, bending_command, make_path, place_rows
from tauten.service.plant.plant import (
    PlantSettings,
    plant_robot,
    plant_setup,
    quick_enough,
    simulate,
    warm_plant,
)
from tauten.service.plant.processes import Child, DemoError, StartLimit, child, free_ports
from tauten.service.plant.reach import reach_plan, reached
from tauten.service.plant.receiver import find_receiver, receiver_path
from tauten.service.plant.streaming import StreamSettings, stream
from tauten.service.plant.waypoints import (
    PathError,
    TargetPath,
    csv_text_path,
    path_text,
    save_path,
    without_sign_changes,
)

__all__ = [
    "plant_robot",
    "plant_setup",
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
    "PlantSettings",
    "StartLimit",
    "StreamSettings",
    "TargetPath",
    "bending_command",
    "child",
    "csv_text_path",
    "find_receiver",
    "free_ports",
    "make_path",
    "own_steps",
    "reach_plan",
    "reached",
    "quick_enough",
    "receiver_path",
    "run_demo",
    "path_text",
    "place_rows",
    "save_path",
    "without_sign_changes",
    "simulate",
    "stream",
    "warm_plant",
]
