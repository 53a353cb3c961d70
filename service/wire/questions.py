"""Questions to a node over Zenoh."""

from __future__ import annotations

import json
import logging
import time
from typing import Any

import zenoh

from tauten.service.link import Keys, NetworkError, is_alive
from tauten.service.process import StopFlag
from tauten.service.wire.messages import JSON

log = logging.getLogger(__name__)

_RETRY = 0.2  # s
_PATIENCE = 2.0  # s for an answer


def wait_for(session: zenoh.Session, token: str, stop: StopFlag) -> bool:
    """Wait until a liveliness token is declared; False after a request to stop.

    Args:
        session: open Zenoh session.
        token: its key.
        stop: ends the wait.
    """
    waiting = False
    while not stop.requested:
        if is_alive(session, token):
            return True
        if not waiting:
            log.info("waiting for %s", token)
        waiting = True
        time.sleep(_RETRY)
    return False


def ask_description(session: zenoh.Session, keys: Keys) -> dict[str, Any]:
    """How a node describes the robot it serves.

    Args:
        session: open Zenoh session.
        keys: of the robot.

    Raises:
        NetworkError: the node does not answer with a description.
    """
    for reply in session.get(keys.description, timeout=_PATIENCE):
        if reply.ok is not None and str(reply.ok.encoding) == JSON:
            found: dict[str, Any] = json.loads(bytes(reply.ok.payload))
            return found
    raise NetworkError(f"the node of {keys.robot!r} does not describe itself")
