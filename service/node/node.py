"""The node: targets from Zenoh become actuation at a fixed rate.

A tick: wait, read what has arrived, decide, limit, publish actuation; then, in the time that is left of the
period, move the model, prepare the next decision, publish the tick, and once a second health.
"""

from __future__ import annotations

import gc
import logging
import math
import time
from collections import deque
from collections.abc import Iterator

import numpy as np
import zenoh

from tauten.model.numerics import Array
from tauten.service.describing import describe
from tauten.service.log import LogRecorder
from tauten.service.node.answers import QuestionAnswers
from tauten.service.node.clock import Beat, Clock, punctual_clock
from tauten.service.node.inputs import Goal, NodeInputs
from tauten.service.node.loop import Action, ControlLoop
from tauten.service.node.metrics import prometheus_text
from tauten.service.node.model_watch import FallBack
from tauten.service.node.outputs import (
    NodeOutputs,
    Readout,
    ShapePublisher,
    contact_diagnostic,
)
from tauten.service.node.state_machine import Signals
from tauten.service.node.statistics import LoopStatistics
from tauten.service.process import StopFlag
from tauten.service.setup import Setup
from tauten.service.wire import Cause, Diagnostic, Mode, Positions, Tick, encode_health

log = logging.getLogger(__name__)

_HEALTH_PERIOD = 1.0  # s
_HEALTH_DELAY = 0.5  # s that health waits for ticks with time left
_SPARE = 3e-4  # s that are enough for a part of health
# reports between collections of all garbage, which take most of a millisecond; new objects alone take none
_ALL_GARBAGE = 60
_BRIEF = 2.5e-4  # s that are enough to publish a tick and to read the next target
_WAITING = 10  # ticks that wait to be published at most, where there is never time left
_CREDIBLE = 10.0  # s; a longer latency means that two clocks do not agree
_LOOK = 2e-4  # s between two reads while a tick waits for its target
_QUICK = 8e-4  # s; only decisions as quick as this are rehearsed, in the 1.2 ms that are for it


class Node:
    """Serves one robot over one Zenoh session."""

    def __init__(
        self,
        setup: Setup,
        loop: ControlLoop,
        session: zenoh.Session,
        recorder: LogRecorder | None,
        closed_loop: bool,
        fall_back: FallBack | None = None,
        step: float = math.nan,
    ) -> None:
        """Declare subscribers, publishers and queryables.

        Args:
            setup: the robot.
            loop: its controller and limiter, at the start and warm.
            session: open Zenoh session.
            recorder: of the log; None: none is kept.
            closed_loop: whether measurements correct the targets.
            fall_back: watches a reduced model; None with the full one.
            step: time of a control step before the loop runs [s]; NaN where it is not known.
        """
        robot = setup.robot
        self._robot = robot
        self._loop = loop
        self._recorder = recorder
        self._fall_back = fall_back
        period = 0.0 if fall_back is None else fall_back.period
        self._inputs = NodeInputs(session, robot, setup.service, closed_loop, recorder, period)
        self._outputs = NodeOutputs(session, robot, recorder)
        self._shape = ShapePublisher(session, robot)
        description = describe(setup, loop.controller.effector_values)
        self._answers = QuestionAnswers(session, robot.name, description.as_json().encode())
        self._statistics = LoopStatistics(robot.actuators, robot.effector_layout, robot.size)
        self._facts = {
            "factorisation": robot.body.linear_solver,
            "model": setup.order,
            "qp_solver": setup.controller.qp_solver,
            "basis": setup.basis_name,
            "digest": robot.digest,
            "loop": "closed" if closed_loop else "open",
            "step_at_start_ms": f"{1e3 * step:.4g}",
        }
        self._unpublished: deque[tuple[Tick, Readout | None]] = deque()
        self._index = 0
        self._decide_seconds = 0.0  # of the last decision
        self._next_health = self._overdue = 0.0
        self._reports = 0
        self._report: Iterator[None] = iter(())

    def run(self, stop: StopFlag, event: bool = False) -> None:
        """Tick until a request to stop; then release the cables, after an error without the model.

        Args:
            stop: ends the loop; a second request shortens the release to what the rate limits permit.
            event: whether a tick that follows comes with its target. It waits for one until half a period
                after it is due, never less than a period after the last tick: a winch that may turn so
                far in a tick turns no faster.
        """
        clock = punctual_clock(self._robot.h)
        try:
            while not stop.requested:
                beat = clock.wait(self._read_ahead, self._rehearse)
                if event and self._loop.state.mode is Mode.RUN:
                    self._await_target(clock, beat)
                self.tick(clock, beat, shutdown=False)
                if self._fall_back is not None and self._fall_back.wanted:
                    clock = punctual_clock(self._fall_back.switch(self._loop))
            self._release(clock, stop)
        except BaseException:
            self._release_alone(clock, stop)
            raise

    def tick(self, clock: Clock, beat: Beat, shutdown: bool, hurried: bool = False) -> None:
        """One tick at a beat of the clock; `hurried`: the process was requested to end a second time."""
        inputs, loop, index = self._inputs, self._loop, self._index
        inputs.read_targets(index, beat.lateness)
        for command in inputs.read_commands(index):
            inputs.count(command, loop.obey(command))
        effectors = loop.controller.effector_values
        measurement = inputs.read_measurements(effectors, loop.state.mode is not Mode.STOP, index)
        goal, fresh = inputs.goal(effectors, beat.lateness), inputs.take_fresh()
        seen = Signals(goal is not None, beat.slack >= 0.0, measurement, shutdown, hurried)
        begin = time.perf_counter()
        action = loop.tick(None if goal is None else goal.corrected, seen)
        self._decide_seconds = time.perf_counter() - begin
        stamp = time.time_ns()
        self._outputs.actuate(action, stamp, index)
        published = time.perf_counter()
        if not action.decided:  # a target that was not followed is not recorded
            goal = None
        try:
            loop.prepare(inputs.read_obstacles(loop.controller))
        except Exception:
            self._finish(clock, self._tick(beat, action, goal, stamp, 0.0, math.nan))
            raise
        step = self._decide_seconds + time.perf_counter() - published
        tick = self._tick(beat, action, goal, stamp, step, _latency(goal, fresh, stamp))
        self._statistics.add(tick, action, loop.controller.effector_values)
        self._unpublished.append((tick, self._outputs.readout(loop.controller, action.mode)))
        self._index += 1
        self._housekeeping(clock)

    def _release(self, clock: Clock, stop: StopFlag) -> None:
        """Release the cables, then publish what is left."""
        log.info("releasing the cables")
        hurried = False
        self.tick(clock, clock.wait(), shutdown=True)
        while not self._loop.released:
            if stop.urgent and not hurried:
                hurried = True
                log.info("releasing them as fast as the rate limits permit")
            self.tick(clock, clock.wait(), shutdown=True, hurried=hurried)
        self._publish_ticks(clock, 0)
        for _ in self._reporting(clock):
            pass

    def _release_alone(self, clock: Clock, stop: StopFlag) -> None:
        """Release the cables after an error: nothing is read, nor the model used, which may fail again."""
        log.error("releasing the cables after an error")
        while not self._loop.released:
            beat = clock.wait()
            hurried = stop.urgent
            action = self._loop.tick(None, Signals(False, True, Cause.NONE, True, hurried))
            stamp = time.time_ns()
            self._outputs.actuate(action, stamp, self._index)
            self._finish(clock, self._tick(beat, action, None, stamp, 0.0, math.nan))

    def _finish(self, clock: Clock, tick: Tick) -> None:
        """Publish a tick after which the model has failed, before the next actuation, for the log."""
        self._unpublished.append((tick, None))
        self._index += 1
        self._publish_ticks(clock, 0)

    def _read_ahead(self) -> None:
        """Read targets just before a beat, so that the tick has less to read."""
        self._inputs.read_targets(self._index)

    def _rehearse(self) -> None:
        """Compute the decision for the latest target, so that the tick's own is fast."""
        goal = self._inputs.goal(self._loop.controller.effector_values)
        if goal is not None and self._decide_seconds < _QUICK:
            self._loop.rehearse(goal.corrected)

    def _await_target(self, clock: Clock, beat: Beat) -> None:
        """Wait for the target of the tick that is due, and move the grid to targets and late beats."""
        begin = now = time.monotonic()
        while not self._inputs.read_targets(self._index) and now - begin < 0.5 * clock.period:
            time.sleep(_LOOK)
            now = time.monotonic()
        clock.delay(beat.lateness + now - begin)

    def _tick(
        self,
        beat: Beat,
        action: Action,
        goal: Goal | None,
        stamp: int,
        step: float,
        latency: float,
    ) -> Tick:
        certificate, layout = action.actuation.certificate, self._robot.effector_layout
        wanted = corrected = np.zeros((0, 3))  # (p, 3), of points alone
        values = correction = np.zeros(0)
        if goal is not None:
            values = goal.values
            wanted = layout.positions_at(action.actuation.effector, values)
            if goal.correction is not None:
                correction = goal.correction
                corrected = layout.position_changes(correction)
        return Tick(
            stamp=stamp,
            frame=self._robot.frame,
            index=self._index,
            mode=action.mode,
            cause=action.cause,
            status="" if action.status is None else action.status.name,
            goal=_positions(wanted),
            correction=_positions(corrected),
            target_stamp=0 if goal is None else goal.stamp,
            lateness=beat.lateness,
            latency=latency,
            decide=self._decide_seconds,
            step=step,
            slack=beat.slack,
            skipped=beat.skipped,
            deepest_gap=certificate.deepest_gap,
            complementarity=certificate.complementarity,
            stationarity=certificate.stationarity,
            extra_columns=certificate.extra_columns,
            clamped=action.actuation.clamped,
            goal_values=tuple(values.tolist()),
            correction_values=tuple(correction.tolist()),
            checks=action.checks,
        )

    def _publish_ticks(self, clock: Clock, most: int) -> None:
        """Publish ticks while there is time left, and until at most so many wait."""
        waiting = self._unpublished
        while len(waiting) > most or (waiting and clock.remaining > _BRIEF):
            self._outputs.tick(*waiting.popleft())

    def _housekeeping(self, clock: Clock) -> None:
        """Work after the tick: publishing it, the plant's messages, questions, health, garbage."""
        self._publish_ticks(clock, _WAITING if self._recorder is None else 0)  # a log is in order
        self._inputs.record_plant(self._index)
        if self._fall_back is not None:
            self._fall_back.watch.look(self._loop.controller)
        self._answers.answer_one(lambda: self._metrics(clock))
        if self._loop.state.mode is not Mode.STOP:  # the model does not follow a release
            self._shape.publish(self._loop.controller, clock)
        now = time.monotonic()
        if now >= self._next_health:
            for _ in self._report:  # one that never found the time
                pass
            self._next_health, self._overdue = now + _HEALTH_PERIOD, now + _HEALTH_DELAY
            self._report = self._reporting(clock)
        if now >= self._overdue or clock.remaining > _SPARE:
            next(self._report, None)

    def _reporting(self, clock: Clock) -> Iterator[None]:
        """Health and garbage, one part in each tick: all of it takes half a millisecond."""
        diagnostics = self._diagnostics(clock)
        yield
        stamp = time.time_ns()
        payload = encode_health(stamp, self._robot.name, diagnostics)
        yield
        self._outputs.health(payload, stamp, self._index)
        yield
        self._reports += 1
        gc.collect(2 if self._reports % _ALL_GARBAGE == 0 else 0)

    def _metrics(self, clock: Clock) -> bytes:
        diagnostics, times = self._diagnostics(clock), self._statistics.times
        return prometheus_text(self._robot.name, diagnostics, times)

    def _diagnostics(self, clock: Clock) -> list[Diagnostic]:
        arrived = [self._loop.locks, *self._inputs.diagnostics(), self._shape.diagnostic()]
        if self._robot.n_c > 0:
            arrived.append(contact_diagnostic(self._loop.controller))
        if self._fall_back is not None:
            arrived.append(self._fall_back.watch.diagnostic())
        return self._statistics.diagnostics(clock, arrived, self._recorder, self._facts)


def _latency(goal: Goal | None, fresh: bool, stamp: int) -> float:
    """Seconds from a target's header to the actuation that follows it; NaN where unknown."""
    if goal is None or not fresh or goal.stamp == 0:
        return math.nan
    latency = 1e-9 * (stamp - goal.stamp)
    return max(latency, goal.delay) if 0.0 <= latency < _CREDIBLE else math.nan


def _positions(points: Array) -> Positions:
    return tuple((x, y, z) for x, y, z in points.tolist())
