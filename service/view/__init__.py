"""The viewer: a robot in the browser, simulated, served or recorded."""

from tauten.service.view.guard import Guard, problem
from tauten.service.view.server import LoopbackServer, ViewError, open_server
from tauten.service.view.session import ViewSession, ViewUsage
from tauten.service.view.show import ViewSettings, view_served, view_simulation

__all__ = [
    "Guard",
    "LoopbackServer",
    "ViewError",
    "ViewSession",
    "ViewSettings",
    "ViewUsage",
    "open_server",
    "problem",
    "view_served",
    "view_simulation",
]
