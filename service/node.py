"""The node: takes targets from Zenoh, gives actuation at a fixed rate.

A tick is: wait, take the goal, decide, guard, publish; then, in what is left of the period, move
the model, prepare the next decision, publish what the tick was, and once a second health.
"""

from __future__ import annotations

import gc
import logging
import math
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import zenoh

from tauten.service.clock import Beat, Clock
from tauten.service.config import Setup, collector_at_hand, one_blas_thread, warm_controller
from tauten.service.describe import description_json
from tauten.service.health import encode_health
from tauten.service.inbox import RING, Goal, Inbox, reach_of
from tauten.service.keys import Keys
from tauten.service.loop import Action, ControlLoop
from tauten.service.messages import (
    HEALTH,
    JOINTS,
    JSON,
    POINT,
    TICK,
    Joints,
    Point,
    encode_joints,
    encode_point,
    typestore,
)
from tauten.service.network import Network, NetworkError, Role, open_session
from tauten.service.outlet import Outlet
from tauten.service.overhear import PlantRecorder
from tauten.service.record import Entry, Recorder
from tauten.service.stopping import StopFlag
from tauten.service.tick import Mode, Tick, encode_tick
from tauten.service.vitals import Vitals

log = logging.getLogger(__name__)

_HEALTH_PERIOD = 1.0  # s


class Node:
    """Serves one robot over one Zenoh session."""

    def __init__(
        self, setup: Setup, loop: ControlLoop, session: zenoh.Session, recorder: Recorder | None
    ) -> None:
        """Declare subscribers and publishers.

        Args:
            setup: the robot.
            loop: its controller and guard, at rest and warm.
            session: open Zenoh session.
            recorder: of the log; None: none is kept.
        """
        robot = setup.robot
        self._robot = robot
        self._loop = loop
        self._recorder = recorder
        keys, names = Keys(robot.name), robot.effector_names
        self._targets = keys.targets(names)
        # rings live in Zenoh: nothing runs Python code when a target arrives
        sources = [
            session.declare_subscriber(key, zenoh.handlers.RingChannel(RING))
            for key in self._targets
        ]
        settings = robot.config.service
        reach = reach_of(robot.size)
        rest = robot.effector(robot.rest())
        self._inbox = Inbox(sources, robot.frame, rest, reach, settings.target_timeout)
        self._plant = None if recorder is None else PlantRecorder(session, robot, recorder)
        self._actuation = Outlet(session, keys.actuation, JOINTS)
        self._effectors = [Outlet(session, key, POINT) for key in keys.effectors(names)]
        self._tick = Outlet(session, keys.tick, TICK)
        self._health = Outlet(session, keys.health, HEALTH, urgent=False)
        self._vitals = Vitals()
        self._facts = {
            "factorisation": robot.linear_solver,
            "qp_solver": robot.config.controller.qp_solver,
            "basis": setup.basis_name,
            "digest": robot.digest,
        }
        self._index = 0
        self._next_health = 0.0

    def run(self, stop: StopFlag) -> None:
        """Tick until asked to stop, or until something breaks; then release the cables."""
        clock = Clock(self._robot.h)
        try:
            while not stop.requested:
                self._follow(clock, clock.wait())
        finally:
            self._release(clock)

    def _follow(self, clock: Clock, beat: Beat) -> None:
        """One tick."""
        now = time.monotonic()
        self._record_targets(self._inbox, now)
        goal = self._inbox.goal(now, self._loop.controller.effector)
        begin = time.perf_counter()
        action = self._loop.decide(None if goal is None else goal.positions)
        decided = time.perf_counter()
        stamp = self._publish(action)
        published = time.perf_counter()
        self._loop.prepare()
        decide = decided - begin
        step = decide + time.perf_counter() - published
        self._finish_tick(beat, action, goal, stamp, decide, step)
        self._housekeeping(clock)

    def _release(self, clock: Clock) -> None:
        """Let the cables go in a ramp."""
        log.info("releasing the cables")
        for action in self._loop.release(self._robot.config.service.release_time):
            beat = clock.wait()
            stamp = self._publish(action)
            self._finish_tick(beat, action, None, stamp, 0.0, 0.0)
        self._publish_health(clock)

    def _publish(self, action: Action) -> int:
        """Send actuation and the model's effectors; returns when that was [ns since the epoch]."""
        robot = self._robot
        stamp = time.time_ns()
        joints = Joints(
            stamp, robot.frame, robot.cable_names,
            tuple(action.pull.tolist()), tuple(action.tension.tolist()),
        )  # fmt: skip
        self._send(self._actuation, encode_joints(joints), stamp)
        if action.mode is not Mode.STOP:  # the model does not follow a release
            for outlet, (x, y, z) in zip(self._effectors, action.effector.tolist(), strict=True):
                self._send(outlet, encode_point(Point(stamp, robot.frame, (x, y, z))), stamp)
        return stamp

    def _finish_tick(
        self, beat: Beat, action: Action, goal: Goal | None, stamp: int, decide: float, step: float
    ) -> None:
        certificate = action.certificate
        fresh = goal is not None and goal.fresh and goal.stamp > 0
        tick = Tick(
            stamp=stamp,
            frame=self._robot.frame,
            index=self._index,
            mode=action.mode,
            status="" if action.status is None else action.status.name,
            goal=() if goal is None else tuple((x, y, z) for x, y, z in goal.positions.tolist()),
            target_stamp=0 if goal is None else goal.stamp,
            lateness=beat.lateness,
            latency=1e-9 * (stamp - goal.stamp) if goal is not None and fresh else math.nan,
            decide=decide,
            step=step,
            slack=beat.slack,
            skipped=beat.skipped,
            deepest_gap=certificate.deepest_gap,
            complementarity=certificate.complementarity,
            stationarity=certificate.stationarity,
            extra_columns=certificate.extra_columns,
            clamped=action.clamped,
        )
        self._send(self._tick, encode_tick(tick), stamp)
        self._vitals.add(tick)
        self._index += 1

    def _housekeeping(self, clock: Clock) -> None:
        """What does not belong to the tick: the plant's messages, health, garbage."""
        if self._plant is not None:
            self._plant.drain(self._index)
        now = time.monotonic()
        if now >= self._next_health:
            self._next_health = now + _HEALTH_PERIOD
            self._publish_health(clock)
            gc.collect()

    def _publish_health(self, clock: Clock) -> None:
        stamp = time.time_ns()
        diagnostics = self._vitals.diagnostics(
            clock, self._inbox.tally, self._recorder, self._facts
        )
        self._send(self._health, encode_health(stamp, self._robot.name, diagnostics), stamp)

    def _send(self, outlet: Outlet, payload: bytes, stamp: int) -> None:
        outlet.put(payload)
        if self._recorder is not None:
            entry = Entry(outlet.key, outlet.kind, payload, False, stamp, stamp, self._index)
            self._recorder.write(entry)

    def _record_targets(self, inbox: Inbox, now: float) -> None:
        """Take targets in; those that were accepted go into the log as they came."""
        accepted = inbox.drain(now)
        if self._recorder is None:
            return
        seen = time.time_ns()
        for target in accepted:
            key, json = self._targets[target.effector], target.encoding.startswith(JSON)
            made = target.point.stamp or seen
            self._recorder.write(Entry(key, POINT, target.payload, json, seen, made, self._index))


def serve(setup: Setup, network: Network, log_path: Path | None, stop: StopFlag) -> None:
    """Serve a robot until asked to stop.

    Args:
        setup: the robot.
        network: where to meet.
        log_path: MCAP file to record to; None: none.
        stop: raised to stop.

    Raises:
        NetworkError: no session, or another node serves this robot already.
        OSError: the log cannot be created.
    """
    keys = Keys(setup.robot.name)
    with ExitStack() as stack:
        stack.enter_context(one_blas_thread())
        loop = ControlLoop(warm_controller(setup))
        typestore()
        session = open_session(network, Role.NODE, setup.robot.name)
        stack.callback(session.close)
        refuse_second_node(session, keys)
        recorder = None
        if log_path is not None:
            recorder = Recorder(log_path, setup.metadata())
            stack.callback(recorder.close)
        node = Node(setup, loop, session, recorder)
        stack.enter_context(answered(session, keys, description_json(setup)))
        stack.enter_context(collector_at_hand())
        log.info("serving %s at %g Hz", setup.robot.name, setup.robot.config.controller.rate)
        node.run(stop)


def refuse_second_node(session: zenoh.Session, keys: Keys) -> None:
    """Make sure that no other node drives the same cables.

    Raises:
        NetworkError: one does.
    """
    if any(reply.ok is not None for reply in session.liveliness().get(keys.token, timeout=1.0)):
        raise NetworkError(f"another node serves {keys.robot!r} already: stop it first")


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
