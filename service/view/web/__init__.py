"""The web server of the viewer, and what stands between it and browsers."""

from tauten.service.view.web.guard import Guard
from tauten.service.view.web.server import (
    FIRST_PORT,
    LoopbackServer,
    check_port,
    open_server,
)

__all__ = ["FIRST_PORT", "Guard", "LoopbackServer", "check_port", "open_server"]
