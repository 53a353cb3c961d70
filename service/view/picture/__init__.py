"""The picture of a robot in the browser: skin, actuators, surroundings, and where one looks from."""

from tauten.service.view.picture.arrows import Arrows
from tauten.service.view.picture.cameras import (
    FIELD_OF_VIEW,
    PANEL,
    PRESETS,
    SHEET,
    Preset,
    camera_of,
    show_preset,
)
from tauten.service.view.picture.forces import ForceNumbers
from tauten.service.view.picture.legend import legend_html, legend_rows
from tauten.service.view.picture.reach import ReachDrawing, nearest_of
from tauten.service.view.picture.scene import TRAIL, RobotScene
from tauten.service.view.picture.strain import COLOURS as STRAINS
from tauten.service.view.picture.strain import StrainSkin, strain_bar
from tauten.service.view.picture.surroundings import above, scale_text

__all__ = [
    "Arrows",
    "FIELD_OF_VIEW",
    "PANEL",
    "ForceNumbers",
    "PRESETS",
    "ReachDrawing",
    "RobotScene",
    "StrainSkin",
    "Preset",
    "SHEET",
    "STRAINS",
    "TRAIL",
    "above",
    "camera_of",
    "legend_html",
    "legend_rows",
    "nearest_of",
    "scale_text",
    "show_preset",
    "strain_bar",
]
