"""The viewer: a robot in the browser, simulated, served or recorded."""

from tauten.service.view.server import ViewError
from tauten.service.view.show import ViewSettings, view_simulation

__all__ = ["ViewError", "ViewSettings", "view_simulation"]
