"""Commands to a node from outside, and its answers to them."""

from __future__ import annotations

import json
import math
import re
import socket
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import zenoh

from tauten.service.link.keys import Keys
from tauten.service.link.modes import Cause, Mode, OperatorCommand, OperatorOrder
from tauten.service.link.network import (
    HOST,
    Network,
    NetworkError,
    Role,
    await_token,
    is_alive,
    node_port,
    session_of,
)

_PATIENCE = 5.0  # s until a node must be alive
_SOON = 2.0  # s until one that is alive is found
_ANSWER = 20.0  # s until a node must have carried a command out, on a machine that is busy too
_STEP = re.compile(r"^tauten_system_step_at_start_ms\{.*\} (\S+)$", re.M)
_PAUSE = 0.01  # s between two questions
_JSON = "application/json;std_msgs/msg/String"  # needs no code that writes CDR


class OrderError(ValueError):
    """An order that the node refuses; the text says why."""


def is_there(robot: str, network: Network, token: str) -> bool:
    """Whether the liveliness token of a robot's node or plant appears."""
    with session_of(network, Role.OTHER, robot) as session:
        end = time.monotonic() + _SOON
        while not is_alive(session, token):
            if time.monotonic() > end:
                return False
            time.sleep(0.1)
        return True


@contextmanager
def node_of(robot: str, network: Network, patience: float | None = None) -> Iterator[zenoh.Session]:
    """A session, as soon as the robot's node is alive.

    A node that is getting ready is waited for.

    Args:
        robot: name.
        network: of the robot.
        patience: time after which the wait ends where there is none [s]; None: 5 s.

    Raises:
        NetworkError: no node is alive.
    """
    keys = Keys(robot)
    with session_of(network, Role.OTHER, robot, connected=False) as session:
        end = time.monotonic() + (_PATIENCE if patience is None else patience)

        def in_vain() -> bool:
            return time.monotonic() > end and not is_alive(session, keys.starting)

        if not await_token(session, keys.token, in_vain, _PAUSE):
            raise NetworkError(_unanswered(robot, network))
        yield session


def _unanswered(robot: str, network: Network) -> str:
    """What is known where no node of a robot has answered: that there is none only where nothing listens."""
    silence = f"no node of {robot!r} has answered within {_PATIENCE:g} s"
    if network.config is not None:
        return f"{silence} by way of {network.config}: is it running, and connected to the same router?"
    port = node_port(network, robot)
    try:
        socket.create_connection((HOST, port), timeout=0.5).close()
    except OSError:
        return (
            f"no node serves {robot!r} on port {port}: start it with tauten serve and the robot's name or "
            "file, or give the --port on which it is served"
        )
    return (
        f"{silence}, but something listens on its port {port}: the node may have too many connections or no "
        "processor time; try again, or press the robot's emergency stop"
    )


@dataclass(frozen=True, slots=True)
class NodeAnswer:
    """What a node says about the commands it has got, and what it does.

    Attributes:
        accepted: commands that it has carried out.
        refused: commands that it has not.
        refusal: why not, of the last one.
        mode: of the node.
        cause: why it does not follow.
        let_go: what had a grasp when it was let go last; empty where nothing had, or can have.
    """

    accepted: int
    refused: int
    refusal: str
    mode: Mode
    cause: Cause
    let_go: str = ""


def send_command(robot: str, network: Network, command: OperatorOrder) -> NodeAnswer:
    """Send an operator's command and wait until the node has carried it out.

    Where several operators send commands at the same time, the answer may be that to another one's.

    Raises:
        NetworkError: no node, or one that does not answer.
        OrderError: the node refuses it; the text is the node's.
    """
    with node_of(robot, network) as session:
        if command in (OperatorCommand.STOP, OperatorCommand.HOLD):
            put_command(session, robot, command)  # before any question
            answer = _answer_that(session, robot, lambda one: _shows(one, command))
            if command is OperatorCommand.HOLD and answer.mode is Mode.STOP:
                raise OrderError(
                    f"{robot}: hold is not possible now: it has stopped, reset it first"
                )
            return answer
        before = _answer_that(session, robot, lambda one: True)
        put_command(session, robot, command)
        known = before.accepted + before.refused
        answer = _answer_that(session, robot, lambda one: one.accepted + one.refused > known)
    if answer.refused > before.refused:
        raise OrderError(f"{robot}: {answer.refusal}")
    return answer


def _shows(answer: NodeAnswer, command: OperatorOrder) -> bool:
    """Whether a node shows that it has got a stop or a hold."""
    if answer.mode is Mode.STOP:
        return True
    return command is OperatorCommand.HOLD and answer.cause is Cause.OPERATOR


def _answer_that(
    session: zenoh.Session, robot: str, wanted: Callable[[NodeAnswer], bool]
) -> NodeAnswer:
    """The node's first answer that is as wanted."""
    end, answers = time.monotonic() + _ANSWER, 0
    while time.monotonic() < end:
        text = ask_metrics(session, robot)
        if text is not None and wanted(answer := answer_in(text.decode())):
            return answer
        answers += text is not None
        time.sleep(_PAUSE)
    if answers:
        raise NetworkError(
            f"the node of {robot!r} answers, but has not carried the command out within {_ANSWER:g} s: a "
            "router may not permit it to this process; press the robot's emergency stop"
        )
    raise NetworkError(f"the node of {robot!r} does not answer within {_ANSWER:g} s")


def answer_in(text: str) -> NodeAnswer:
    """The node's answer in its metrics."""
    # once a command is under way
    from prometheus_client.parser import text_string_to_metric_families

    samples = {s.name: s for f in text_string_to_metric_families(text) for s in f.samples}
    said = samples.get("tauten_commands_info")
    now = samples["tauten_decisions_info"].labels
    contacts = samples.get("tauten_contacts_info")
    let_go = "" if contacts is None else contacts.labels.get("last_let_go", "")
    return NodeAnswer(
        accepted=int(samples["tauten_commands_accepted"].value),
        refused=int(samples["tauten_commands_refused"].value),
        refusal="" if said is None else said.labels["last_refusal"],
        mode=Mode(now["mode"]),
        cause=Cause(now["cause"]),
        let_go="" if let_go == "none" else let_go,
    )


def step_at_start(session: zenoh.Session, robot: str) -> float:
    """Time of a control step that the node measured before its loop ran [s]; NaN where it does not say."""
    found = _STEP.search((ask_metrics(session, robot) or b"").decode())
    return 1e-3 * float(found[1]) if found else math.nan


def put_command(session: zenoh.Session, robot: str, command: OperatorOrder) -> None:
    """Send a command ahead of all other messages of the session; it is never dropped."""
    session.put(
        Keys(robot).command,
        json.dumps({"data": str(command)}).encode(),
        encoding=_JSON,
        congestion_control=zenoh.CongestionControl.BLOCK,
        priority=zenoh.Priority.REAL_TIME,
        express=True,
    )


def ask(session: zenoh.Session, key: str, patience: float = 1.0) -> bytes | None:
    """A node's answer to a question; None when it does not answer.

    Args:
        session: to the robot's node.
        key: of the question.
        patience: how long to wait [s].
    """
    for reply in session.get(key, timeout=patience):
        if reply.ok is not None:
            return bytes(reply.ok.payload)
    return None


def ask_metrics(session: zenoh.Session, robot: str) -> bytes | None:
    """The node's metrics as Prometheus text; None when it does not answer."""
    return ask(session, Keys(robot).metrics)
