"""`tauten serve`: all that a node's loop needs, set up in order and taken down in reverse."""

from __future__ import annotations

import logging
import time
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path

import zenoh

from tauten.controller import warm_controller
from tauten.model import one_blas_thread
from tauten.service.check import check_rate, faster, step_seconds
from tauten.service.describing import log_metadata
from tauten.service.kernels import waiting
from tauten.service.link import address, announced
from tauten.service.log import LogRecorder
from tauten.service.node.loop import ControlLoop
from tauten.service.node.model_watch import make_fall_back
from tauten.service.node.node import Node
from tauten.service.process import (
    ORDINARY,
    RealtimeSettings,
    StopFlag,
    apply_realtime,
    manual_garbage_collection,
    short_switch_interval,
)
from tauten.service.setup import Setup
from tauten.service.wire import Keys, Network, NetworkError, Role, is_alive, session_of, typestore

log = logging.getLogger(__name__)

_CLAIM = 0.3  # s; longer than a token takes to be known everywhere


@dataclass(frozen=True, slots=True)
class ServeSettings:
    """How a robot is served.

    Attributes:
        record: MCAP file to record to; None: none.
        closed_loop: whether measurements correct the targets.
        wait: whether the node is idle until an operator enables it.
        rate_requested: whether the rate was given on the command line: then one that the computer cannot hold
            is an error; for the robot file's rate it is a warning.
        realtime: priority and processors of the loop.
        event: whether a tick waits for its target, see `Node.run`.
    """

    record: Path | None = None
    closed_loop: bool = False
    wait: bool = False
    rate_requested: bool = False
    realtime: RealtimeSettings = ORDINARY
    event: bool = False


def serve(setup: Setup, network: Network, settings: ServeSettings, stop: StopFlag) -> None:
    """Serve a robot until a request to stop.

    Raises:
        NetworkError: no session, or another node serves this robot already.
        RateError: the computer cannot hold the rate given on the command line.
        RealtimeError: priority or processors are not permitted.
        OSError: the log cannot be created.
    """
    keys, rate = Keys(setup.robot.name), setup.robot.integration.rate
    with ExitStack() as stack:
        stack.enter_context(one_blas_thread())
        with stop.interruptible():
            session = stack.enter_context(session_of(network, Role.NODE, setup.robot.name))
            log.info("; ".join(filter(None, ("getting ready", waiting()))))
            stack.enter_context(announced(session, keys.starting))
            controller = warm_controller(setup)
            setup = replace(setup, start="settled" if controller.settled else "rest")
            claim = keys.claim(str(session.info.zid()))
            stack.enter_context(announced(session, claim))
            claimed = time.monotonic()
            step = step_seconds(controller)
            reduced = bool(setup.states)
            advice = faster(setup.path, step, reduced, setup.robot, option=True, here=True)
            check_rate(rate, step, settings.rate_requested, advice)
            loop = ControlLoop(controller, not settings.wait, setup.service, timed=True)
            typestore()
        _settle(session, keys, claim, claimed)
        recorder = None
        if settings.record is not None:
            recorder = LogRecorder(settings.record, log_metadata(setup, controller.effector_values))
            stack.callback(recorder.close)
        fall_back = make_fall_back(setup)
        if fall_back is not None:
            stack.callback(fall_back.watch.close)
        node = Node(setup, loop, session, recorder, settings.closed_loop, fall_back, step)
        stack.enter_context(announced(session, keys.token))
        stack.enter_context(manual_garbage_collection())
        stack.enter_context(short_switch_interval())
        apply_realtime(settings.realtime)
        reached = address(network, setup.robot.name)
        log.info("serving %s at %g Hz, %s", setup.robot.name, rate, reached)
        node.run(stop, settings.event)


def _settle(session: zenoh.Session, keys: Keys, mine: str, begin: float) -> None:
    """Make sure that no other node drives the cables that this one has claimed at a monotonic time [s].

    A claim is a liveliness token with the session's own id. Of nodes that claim a robot at the same
    time, the one with the smallest id continues.

    Raises:
        NetworkError: another node serves the robot, or is about to.
    """
    if not is_alive(session, keys.token):
        time.sleep(max(begin + _CLAIM - time.monotonic(), 0.0))
    claims = session.liveliness().get(keys.claim("*"), timeout=1.0)
    others = [str(reply.ok.key_expr) for reply in claims if reply.ok is not None]
    if is_alive(session, keys.token) or any(other < mine for other in others):
        raise NetworkError(f"another node serves {keys.robot!r} already: stop it first")
