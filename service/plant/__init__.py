"""The simulated robot, streams of targets, and the demo."""

from tauten.service.plant.demo import (
    FIGURE,
    LOG,
    REPORT,
    TARGETS,
    DemoSettings,
    run_demo,
    save_path,
)
from tauten.service.plant.paths import (
    SHAPES,
    PathError,
    PathSettings,
    Plane,
    TargetPath,
    directions,
    make_path,
)
from tauten.service.plant.plant import PlantSettings, simulate
from tauten.service.plant.processes import Child, DemoError, child, free_ports
from tauten.service.plant.streaming import StreamSettings, stream

__all__ = [
    "Child",
    "DemoError",
    "DemoSettings",
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
    "child",
    "directions",
    "free_ports",
    "make_path",
    "run_demo",
    "save_path",
    "simulate",
    "stream",
]
