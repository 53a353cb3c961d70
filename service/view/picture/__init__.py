"""The picture of a robot in the browser: skin, actuators, surroundings, and where one looks from."""

from tauten.service.view.picture.cameras import (
    FIELD_OF_VIEW,
    PRESETS,
    SHEET,
    Preset,
    camera_of,
    show_preset,
)
from tauten.service.view.picture.legend import legend_html
from tauten.service.view.picture.reach import ReachDrawing, nearest_of
from tauten.service.view.picture.scene import TRAIL, RobotScene

__all__ = [
    "FIELD_OF_VIEW",
    "PRESETS",
    "ReachDrawing",
    "RobotScene",
    "Preset",
    "SHEET",
    "TRAIL",
    "camera_of",
    "legend_html",
    "nearest_of",
    "show_preset",
]
