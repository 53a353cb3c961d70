"""The viewer: a robot in the browser, simulated, served or recorded."""

from tauten.service.view.charts import SPAN
from tauten.service.view.panel import ViewPanel
from tauten.service.view.picture import TRAIL, RobotScene
from tauten.service.view.show import (
    SimulationSettings,
    ViewSettings,
    export_log,
    export_simulation,
    following,
    simulated,
    view_log,
    view_served,
    view_simulation,
)
from tauten.service.view.web import Guard, check_port, open_server

__all__ = [
    "Guard",
    "SimulationSettings",
    "RobotScene",
    "SPAN",
    "TRAIL",
    "ViewPanel",
    "ViewSettings",
    "check_port",
    "export_log",
    "export_simulation",
    "open_server",
    "following",
    "simulated",
    "view_log",
    "view_served",
    "view_simulation",
]
