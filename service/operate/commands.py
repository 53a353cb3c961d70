"""Operating a node from outside: commands, and its metrics over HTTP."""

from __future__ import annotations

import http.server
import logging
import time
from collections.abc import Iterator
from contextlib import contextmanager

import zenoh

from tauten.service.process import StopFlag
from tauten.service.wire import (
    CDR,
    TEXT,
    Keys,
    Network,
    NetworkError,
    OperatorOrder,
    Rejection,
    Role,
    Tick,
    decode_tick,
    encode_command,
    is_alive,
    open_session,
)

log = logging.getLogger(__name__)

_PATIENCE = 5.0  # s until a node must be alive
_EFFECT = 0.3  # s from a command to ticks after it
_CONTENT = "text/plain; version=0.0.4; charset=utf-8"


def is_there(robot: str, network: Network, token: str, patience: float = 2.0) -> bool:
    """Whether a liveliness token appears.

    Args:
        robot: name.
        network: of the robot.
        token: of its node or plant.
        patience: time to wait for it [s].
    """
    session = open_session(network, Role.OTHER, robot)
    try:
        end = time.monotonic() + patience
        while not is_alive(session, token):
            if time.monotonic() > end:
                return False
            time.sleep(0.1)
        return True
    finally:
        session.close()  # type: ignore[no-untyped-call]


@contextmanager
def node_of(robot: str, network: Network) -> Iterator[zenoh.Session]:
    """A session, once the robot's node is alive.

    Raises:
        NetworkError: no node is alive.
    """
    session, token = open_session(network, Role.OTHER, robot), Keys(robot).token
    try:
        end = time.monotonic() + _PATIENCE
        while not is_alive(session, token):
            if time.monotonic() > end:
                raise NetworkError(f"no node serves {robot!r}: start it with tauten serve {robot}")
            time.sleep(0.1)
        yield session
    finally:
        session.close()  # type: ignore[no-untyped-call]


def send_command(robot: str, network: Network, command: OperatorOrder) -> Tick:
    """Send an operator's command; returns a tick of the node after it.

    Args:
        robot: name.
        network: of the robot.
        command: what the node is to do.

    Raises:
        NetworkError: no node, or one that does not tick.
    """
    keys = Keys(robot)
    with node_of(robot, network) as session:
        ticks = session.declare_subscriber(keys.tick, zenoh.handlers.RingChannel(1))
        session.put(
            keys.command,
            encode_command(command),
            encoding=f"{CDR};{TEXT}",
            # ahead of all other messages of the session, and never dropped
            congestion_control=zenoh.CongestionControl.BLOCK,
            priority=zenoh.Priority.REAL_TIME,
            express=True,
        )
        time.sleep(_EFFECT)
        end = time.monotonic() + _PATIENCE
        while time.monotonic() < end:
            sample = ticks.try_recv()
            if sample is not None:
                tick = decode_tick(bytes(sample.payload))
                if not isinstance(tick, Rejection):
                    return tick
            time.sleep(0.01)
    raise NetworkError(f"the node of {robot!r} does not tick")


def ask_metrics(session: zenoh.Session, robot: str) -> bytes | None:
    """The node's metrics as Prometheus text; None when it does not answer."""
    for reply in session.get(Keys(robot).metrics, timeout=1.0):
        if reply.ok is not None:
            return bytes(reply.ok.payload)
    return None


def serve_metrics(session: zenoh.Session, robot: str, port: int, stop: StopFlag) -> None:
    """Serve the node's metrics over HTTP on loopback until `stop` is raised.

    Args:
        session: to the robot's node.
        robot: name.
        port: TCP port.
        stop: raised to stop.

    Raises:
        OSError: the port is taken.
    """

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            text = ask_metrics(session, robot) if self.path == "/metrics" else None
            known = self.path == "/metrics"
            self.send_response(200 if text is not None else 503 if known else 404)
            self.send_header("Content-Type", _CONTENT)
            self.end_headers()
            self.wfile.write(text or b"")

        def log_message(self, format: str, *args: object) -> None:
            log.debug(format, *args)

    with http.server.HTTPServer(("127.0.0.1", port), Handler) as server:
        server.timeout = 0.2
        log.info("metrics of %s at http://127.0.0.1:%d/metrics", robot, server.server_port)
        while not stop.requested:
            server.handle_request()
