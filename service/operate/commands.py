"""Operating a node from outside: commands, and its metrics over HTTP."""

from __future__ import annotations

import http.server
import logging
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import zenoh
from prometheus_client.parser import text_string_to_metric_families

from tauten.service.process import StopFlag
from tauten.service.wire import (
    CDR,
    TEXT,
    Cause,
    Keys,
    Mode,
    Network,
    NetworkError,
    OperatorOrder,
    Role,
    encode_command,
    is_alive,
    open_session,
)

log = logging.getLogger(__name__)

_PATIENCE = 5.0  # s until a node must be alive
_ANSWER = 20.0  # s until a node must have carried a command out, on a machine that is busy too
_PAUSE = 0.01  # s between two questions
_CONTENT = "text/plain; version=0.0.4; charset=utf-8"


class OrderError(ValueError):
    """An order that the node refuses; the text says why."""


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


@dataclass(frozen=True, slots=True)
class NodeAnswer:
    """What a node says about the commands it has got, and what it does.

    Attributes:
        accepted: commands that it has carried out.
        refused: commands that it has not.
        refusal: why not, of the last one.
        mode: of the node.
        cause: why it does not follow.
    """

    accepted: int
    refused: int
    refusal: str
    mode: Mode
    cause: Cause


def send_command(robot: str, network: Network, command: OperatorOrder) -> NodeAnswer:
    """Send an operator's command and wait until the node has carried it out.

    Where several operators send commands at the same time, the answer may be that to another one's.

    Args:
        robot: name.
        network: of the robot.
        command: what the node is to do.

    Raises:
        NetworkError: no node, or one that does not answer.
        OrderError: the node refuses it; the text is the node's.
    """
    with node_of(robot, network) as session:
        before = _answer_after(session, robot, -1)
        put_command(session, robot, command)
        answer = _answer_after(session, robot, before.accepted + before.refused)
    if answer.refused > before.refused:
        raise OrderError(f"{robot}: {answer.refusal}")
    return answer


def _answer_after(session: zenoh.Session, robot: str, commands: int) -> NodeAnswer:
    """The node's answer once it has got more commands than so many."""
    end = time.monotonic() + _ANSWER
    while time.monotonic() < end:
        text = ask_metrics(session, robot)
        if text is not None:
            answer = _answer_in(text.decode())
            if answer.accepted + answer.refused > commands:
                return answer
        time.sleep(_PAUSE)
    raise NetworkError(f"the node of {robot!r} does not answer within {_ANSWER:g} s")


def _answer_in(text: str) -> NodeAnswer:
    """The node's answer in its metrics."""
    samples = {s.name: s for f in text_string_to_metric_families(text) for s in f.samples}
    said = samples.get("tauten_commands_info")
    now = samples["tauten_decisions_info"].labels
    return NodeAnswer(
        accepted=int(samples["tauten_commands_accepted"].value),
        refused=int(samples["tauten_commands_refused"].value),
        refusal="" if said is None else said.labels["last_refusal"],
        mode=Mode(now["mode"]),
        cause=Cause(now["cause"]),
    )


def put_command(session: zenoh.Session, robot: str, command: OperatorOrder) -> None:
    """Send a command ahead of all other messages of the session; it is never dropped.

    Args:
        session: to the robot's node.
        robot: name.
        command: what the node is to do.
    """
    session.put(
        Keys(robot).command,
        encode_command(command),
        encoding=f"{CDR};{TEXT}",
        congestion_control=zenoh.CongestionControl.BLOCK,
        priority=zenoh.Priority.REAL_TIME,
        express=True,
    )


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
