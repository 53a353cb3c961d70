"""`tauten serve`: everything around a node's loop, set up in order and taken down in reverse."""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

import zenoh

from tauten.service.log import LogRecorder
from tauten.service.node.description import description_json
from tauten.service.node.fall_back import make_fall_back
from tauten.service.node.loop import ControlLoop
from tauten.service.node.node import Node
from tauten.service.process import (
    ORDINARY,
    RealtimeSettings,
    StopFlag,
    apply_realtime,
    collector_at_hand,
    one_blas_thread,
    short_turns,
)
from tauten.service.rate_check import check_rate, step_seconds
from tauten.service.setup import Setup, warm_controller
from tauten.service.wire import (
    JSON,
    Keys,
    Network,
    NetworkError,
    Role,
    is_alive,
    open_session,
    typestore,
)

log = logging.getLogger(__name__)

_CLAIM = 0.3  # s; longer than a token takes to be known everywhere


@dataclass(frozen=True, slots=True)
class ServeSettings:
    """How a robot is served.

    Attributes:
        record: MCAP file to record to; None: none.
        closed_loop: whether measurements correct the targets.
        wait: whether the node stays idle until an operator enables it.
        rate_asked: whether somebody asked for the rate; where the robot file did, one that the machine
            cannot hold is only warned of.
        realtime: priority and processors of the loop.
        event: whether a tick waits for its target, see `Node.run`.
    """

    record: Path | None = None
    closed_loop: bool = False
    wait: bool = False
    rate_asked: bool = False
    realtime: RealtimeSettings = ORDINARY
    event: bool = False


def serve(setup: Setup, network: Network, settings: ServeSettings, stop: StopFlag) -> None:
    """Serve a robot until asked to stop.

    Args:
        setup: the robot.
        network: where to meet.
        settings: how.
        stop: raised to stop.

    Raises:
        NetworkError: no session, or another node serves this robot already.
        RateError: the machine cannot hold the rate that was asked for.
        RealtimeError: priority or processors are not to be had.
        OSError: the log cannot be created.
    """
    keys, rate = Keys(setup.robot.name), setup.robot.config.controller.rate
    with ExitStack() as stack:
        stack.enter_context(one_blas_thread())
        log.info("getting ready; kernels are compiled the first time, which takes a minute or two")
        controller = warm_controller(setup)
        check_rate(rate, step_seconds(controller), settings.rate_asked)
        loop = ControlLoop(controller, enabled=not settings.wait)
        typestore()
        session = open_session(network, Role.NODE, setup.robot.name)
        stack.callback(session.close)
        stack.enter_context(claimed(session, keys))
        recorder = None
        if settings.record is not None:
            recorder = LogRecorder(settings.record, setup.metadata())
            stack.callback(recorder.close)
        fall_back = make_fall_back(setup)
        if fall_back is not None:
            stack.callback(fall_back.watch.close)
        node = Node(setup, loop, session, recorder, settings.closed_loop, fall_back)
        stack.enter_context(answered(session, keys, description_json(setup)))
        stack.enter_context(collector_at_hand())
        stack.enter_context(short_turns())
        apply_realtime(settings.realtime)
        log.info("serving %s at %g Hz", setup.robot.name, rate)
        node.run(stop, settings.event)


@contextmanager
def claimed(session: zenoh.Session, keys: Keys) -> Iterator[None]:
    """Make sure that no other node drives the same cables.

    A claim is a liveliness token under the session's own id. Of nodes that claim a robot at the same
    time, all see each other and the one with the smallest id goes on.

    Raises:
        NetworkError: another node serves the robot, or is about to.
    """
    mine = keys.claim(str(session.info.zid()))
    token = session.liveliness().declare_token(mine)
    try:
        if not is_alive(session, keys.token):
            time.sleep(_CLAIM)
        claims = session.liveliness().get(keys.claim("*"), timeout=1.0)
        others = [str(reply.ok.key_expr) for reply in claims if reply.ok is not None]
        if is_alive(session, keys.token) or any(other < mine for other in others):
            raise NetworkError(f"another node serves {keys.robot!r} already: stop it first")
        yield
    finally:
        token.undeclare()  # type: ignore[no-untyped-call]


@contextmanager
def answered(session: zenoh.Session, keys: Keys, description: bytes) -> Iterator[None]:
    """Declare the liveliness token and answer questions about the robot."""

    def answer(query: zenoh.Query) -> None:
        query.reply(keys.description, description, encoding=JSON)

    queryable = session.declare_queryable(keys.description, answer)
    token = session.liveliness().declare_token(keys.token)
    try:
        yield
    finally:
        token.undeclare()  # type: ignore[no-untyped-call]
        queryable.undeclare()  # type: ignore[no-untyped-call]
