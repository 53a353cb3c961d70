"""The node: takes targets from Zenoh, gives actuation at a fixed rate.

A tick is: wait, take in what has arrived, decide, guard, publish; then, in what is left of the period,
move the model, prepare the next decision, publish what the tick was, and once a second health.
"""

from __future__ import annotations

import gc
import logging
import math
import time
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import zenoh

from tauten.model.numerics import Array
from tauten.service.log import LogRecorder
from tauten.service.node.clock import Beat, Clock, punctual_clock
from tauten.service.node.fall_back import FallBack
from tauten.service.node.inputs import NodeInputs
from tauten.service.node.loop import Action, ControlLoop
from tauten.service.node.metrics import MetricsAnswer
from tauten.service.node.outputs import NodeOutputs
from tauten.service.node.plant_recorder import PlantRecorder
from tauten.service.node.state_machine import Signals
from tauten.service.node.statistics import LoopStatistics
from tauten.service.process import StopFlag
from tauten.service.setup import Setup
from tauten.service.wire import Diagnostic, Goal, Mode, Positions, Tick, encode_health

log = logging.getLogger(__name__)

_HEALTH_PERIOD = 1.0  # s
_PATIENCE = 0.5  # s that health waits for ticks with time to spare
_SPARE = 3e-4  # s that are enough for a piece of health
# reports from one look at all garbage to the next; it takes most of a millisecond, a look at new objects none
_ALL_GARBAGE = 60
_BRIEF = 2.5e-4  # s that are enough to tell of a tick and to read the next target
_WAITING = 10  # ticks that wait to be told of at most, where there is never time to spare
_CREDIBLE = 10.0  # s; a longer latency says that two clocks do not agree


@dataclass(frozen=True, slots=True)
class _Asked:
    """What a tick was asked for: the goal, and the correction added to it."""

    goal: Goal | None
    correction: Array | None

    @property
    def positions(self) -> Array | None:
        """(p, 3) for the model [m]; None: nothing to follow."""
        if self.goal is None:
            return None
        wanted = self.goal.positions
        return wanted if self.correction is None else wanted + self.correction


_NOTHING = _Asked(None, None)
_LOOK = 2e-4  # s between looks for a target
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
    ) -> None:
        """Declare subscribers and publishers.

        Args:
            setup: the robot.
            loop: its controller and guard, at rest and warm.
            session: open Zenoh session.
            recorder: of the log; None: none is kept.
            closed_loop: whether measurements correct the targets.
            fall_back: what watches a reduced model; None with the full one.
        """
        robot = setup.robot
        self._fall_back = fall_back
        self._robot = robot
        self._loop = loop
        self._recorder = recorder
        self._intake = NodeInputs(session, robot, closed_loop, recorder)
        self._plant = None if recorder is None else PlantRecorder(session, robot, recorder)
        self._out = NodeOutputs(session, robot, recorder)
        self._metrics = MetricsAnswer(session, robot.name)
        self._vitals = LoopStatistics()
        self._facts = {
            "factorisation": robot.linear_solver,
            "model": setup.order,
            "qp_solver": robot.config.controller.qp_solver,
            "basis": setup.basis_name,
            "digest": robot.digest,
            "loop": "closed" if closed_loop else "open",
        }
        self._over: deque[Tick] = deque()
        self._index = 0
        self._decided = 0.0  # s the last decision took
        self._next_health = self._overdue = 0.0
        self._reports = 0
        self._report: Iterator[None] = iter(())

    def run(self, stop: StopFlag, event: bool = False) -> None:
        """Tick until asked to stop, or until something breaks; then release the cables.

        Args:
            stop: raised to stop.
            event: whether a tick that follows comes with its target. It waits for one until half a period
                after it is due, never less than a period after the last tick: a winch that may turn so
                far in a tick turns no faster.
        """
        clock = punctual_clock(self._robot.h)
        try:
            while not stop.requested:
                beat = clock.wait(self._look, self._rehearse)
                if event and self._loop.state.mode is Mode.RUN:
                    self._await_target(clock)
                self.tick(clock, beat, shutdown=False)
                if self._fall_back is not None and self._fall_back.wanted:
                    clock = punctual_clock(self._fall_back.switch(self._loop))
        finally:
            log.info("releasing the cables")
            self.tick(clock, clock.wait(), shutdown=True)
            while not self._loop.released:
                self.tick(clock, clock.wait(), shutdown=True)
            self._tell(clock, 0)
            for _ in self._reporting(clock):
                pass

    def tick(self, clock: Clock, beat: Beat, shutdown: bool) -> None:
        """One tick.

        Args:
            clock: whose misses health reports.
            beat: of the clock.
            shutdown: whether the process was asked to end.
        """
        asked, seen = self._take_in(beat, shutdown)
        begin = time.perf_counter()
        action = self._loop.tick(asked.positions, seen)
        decided = time.perf_counter()
        self._decided = decided - begin
        stamp = time.time_ns()
        self._out.act(action, stamp, self._index)
        published = time.perf_counter()
        self._loop.prepare()
        step = self._decided + time.perf_counter() - published
        tick = self._record(beat, action, asked, stamp, self._decided, step)
        self._vitals.add(tick)
        self._over.append(tick)
        self._index += 1
        self._housekeeping(clock)

    def _look(self) -> None:
        """Read targets that are there already, so that the tick begins with its decision."""
        self._intake.arrived(time.monotonic(), self._index)

    def _rehearse(self) -> None:
        """Go through the decision for the latest target, so that the tick's own is fast."""
        goal = self._intake.goal(time.monotonic(), self._loop.controller.effector)
        if goal is not None and self._decided < _QUICK:
            self._loop.rehearse(goal.positions)

    def _await_target(self, clock: Clock) -> None:
        """Wait for the target of the tick that is due, and let the grid follow the targets."""
        begin = now = time.monotonic()
        while not self._intake.arrived(now, self._index) and now - begin < 0.5 * clock.period:
            time.sleep(_LOOK)
            now = time.monotonic()
        clock.delay(now - begin)

    def _take_in(self, beat: Beat, shutdown: bool) -> tuple[_Asked, Signals]:
        """What has arrived, what to ask the model for, and what the state machine is to know."""
        now, intake, loop = time.monotonic(), self._intake, self._loop
        intake.drain(now, self._index)
        intake.obey(loop.command, self._index)
        effector = loop.controller.effector
        goal = intake.goal(now, effector)
        # a model that does not follow says nothing about the robot
        measured = loop.state.mode is Mode.STOP or intake.observe(now, effector)
        correction = None if intake.feedback is None else intake.feedback.correction
        seen = Signals(goal is not None, beat.slack >= 0.0, measured, shutdown)
        return _Asked(goal, correction), seen

    def _record(
        self, beat: Beat, action: Action, asked: _Asked, stamp: int, decide: float, step: float
    ) -> Tick:
        if action.status is None:  # nothing was decided, whatever was asked
            asked = _NOTHING
        certificate, goal = action.certificate, asked.goal
        latency = math.nan
        if goal is not None and goal.fresh and goal.stamp > 0:
            latency = 1e-9 * (stamp - goal.stamp)
        return Tick(
            stamp=stamp,
            frame=self._robot.frame,
            index=self._index,
            mode=action.mode,
            cause=action.cause,
            status="" if action.status is None else action.status.name,
            goal=() if goal is None else _positions(goal.positions),
            correction=() if asked.correction is None else _positions(asked.correction),
            target_stamp=0 if goal is None else goal.stamp,
            lateness=beat.lateness,
            latency=latency if 0.0 <= latency < _CREDIBLE else math.nan,
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

    def _tell(self, clock: Clock, most: int) -> None:
        """Publish what ticks were, where there is time to spare, until at most so many wait."""
        while len(self._over) > most or (self._over and clock.remaining > _BRIEF):
            self._out.tick(self._over.popleft())

    def _housekeeping(self, clock: Clock) -> None:
        """What does not belong to the tick: telling of it, the plant's messages, metrics, health, garbage."""
        self._tell(clock, _WAITING if self._recorder is None else 0)  # a log is in order
        if self._plant is not None:
            self._plant.drain(self._index)
        if self._fall_back is not None:
            self._fall_back.watch.look(self._loop.controller)
        self._metrics.reply(lambda: self._diagnostics(clock), self._vitals.times)
        now = time.monotonic()
        if now >= self._next_health:
            for _ in self._report:  # one that never found the time
                pass
            self._next_health, self._overdue = now + _HEALTH_PERIOD, now + _PATIENCE
            self._report = self._reporting(clock)
        if now >= self._overdue or clock.remaining > _SPARE:
            next(self._report, None)

    def _reporting(self, clock: Clock) -> Iterator[None]:
        """Health and garbage, a piece a tick: all of it takes half a millisecond."""
        diagnostics = self._diagnostics(clock)
        yield
        stamp = time.time_ns()
        payload = encode_health(stamp, self._robot.name, diagnostics)
        yield
        self._out.health(payload, stamp, self._index)
        yield
        self._reports += 1
        gc.collect(2 if self._reports % _ALL_GARBAGE == 0 else 0)

    def _diagnostics(self, clock: Clock) -> list[Diagnostic]:
        arrived = self._intake.diagnostics()
        if self._fall_back is not None:
            arrived.append(self._fall_back.watch.diagnostic())
        return self._vitals.diagnostics(clock, arrived, self._recorder, self._facts)


def _positions(points: Array) -> Positions:
    return tuple((x, y, z) for x, y, z in np.asarray(points).tolist())
