"""The viewer: a robot in the browser, simulated, served or recorded."""

from tauten.service.view.guard import Guard
from tauten.service.view.playback import PlaybackSession
from tauten.service.view.server import LoopbackServer, ViewError, open_server
from tauten.service.view.session import ViewSession
from tauten.service.view.show import (
    SimulationSettings,
    ViewSettings,
    export_log,
    export_simulation,
    simulation_cost,
    view_log,
    view_served,
    view_simulation,
)
from tauten.service.view.usage import ViewCost

__all__ = [
    "Guard",
    "LoopbackServer",
    "PlaybackSession",
    "SimulationSettings",
    "ViewCost",
    "ViewError",
    "ViewSession",
    "ViewSettings",
    "export_log",
    "export_simulation",
    "open_server",
    "simulation_cost",
    "view_log",
    "view_served",
    "view_simulation",
]
