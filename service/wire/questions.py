"""Questions to a node over Zenoh."""

from __future__ import annotations

import time

import zenoh

from tauten.service.link import Keys, NetworkError, await_token
from tauten.service.process import StopFlag
from tauten.service.wire.description import RobotDescription, read_description

_PATIENCE = 5.0  # s for an answer


def wait_for(session: zenoh.Session, token: str, stop: StopFlag) -> bool:
    """Wait until a liveliness token is declared; False after a request to stop.

    Args:
        session: open Zenoh session.
        token: its key.
        stop: ends the wait.
    """
    return await_token(session, token, lambda: stop.requested) and not stop.requested


def ask_description(session: zenoh.Session, keys: Keys) -> RobotDescription:
    """How a node describes the robot it serves.

    Args:
        session: open Zenoh session.
        keys: of the robot.

    Raises:
        NetworkError: the node does not answer, or not with a description of this version.
    """
    end = time.monotonic() + _PATIENCE
    while time.monotonic() < end:
        wrong: NetworkError | None = None
        for reply in session.get(keys.description, timeout=1.0):
            if reply.ok is None:
                continue
            try:
                return read_description(keys.robot, bytes(reply.ok.payload))
            except NetworkError as error:
                wrong = error
        if wrong is not None:
            raise wrong
    raise NetworkError(f"the node of {keys.robot!r} does not describe itself: see its log")
