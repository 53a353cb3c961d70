"""What a node listens to: targets, commands, measurements; and what of it goes into the log.

Rings live in Zenoh: nothing runs Python code when a message arrives, the loop takes it at its tick.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
import zenoh

from tauten.model import Robot
from tauten.model.numerics import Array
from tauten.service.log import Entry, LogRecorder
from tauten.service.node.feedback import LARGEST, Feedback
from tauten.service.wire import (
    COMMAND_RING,
    JSON,
    POINT,
    POSITION_RING,
    TEXT,
    Commands,
    Diagnostic,
    Goal,
    Keys,
    OperatorCommand,
    PositionSubscriber,
    Received,
    Rejection,
    RejectionReason,
    Source,
    reach_of,
)


class NodeInputs:
    """Collects what arrives for a node.

    Attributes:
        feedback: correction of a closed loop; None in an open one.
    """

    def __init__(
        self, session: zenoh.Session, robot: Robot, closed_loop: bool, recorder: LogRecorder | None
    ) -> None:
        """Declare the subscribers.

        Args:
            session: open Zenoh session.
            robot: whose they are.
            closed_loop: whether measurements correct the targets.
            recorder: of the log; None: none is kept.
        """
        keys, names, settings = Keys(robot.name), robot.effector_names, robot.config.service
        rest, reach = robot.effector(robot.rest()), reach_of(robot.size)

        def ring(key: str, size: int = POSITION_RING) -> Source:
            return session.declare_subscriber(key, zenoh.handlers.RingChannel(size))

        def inbox(keys: tuple[str, ...], timeout: float) -> PositionSubscriber:
            return PositionSubscriber(
                [ring(key) for key in keys], robot.frame, rest, reach, timeout
            )

        self._recorder = recorder
        self._looked = False  # for targets of the tick that is due
        self._target_keys, self._measured_keys = keys.targets(names), keys.measurements(names)
        self._command_key = keys.command
        self._targets = inbox(self._target_keys, settings.target_timeout)
        self._commands = Commands(ring(keys.command, COMMAND_RING))
        self.feedback: Feedback | None = None
        self._measurements: PositionSubscriber | None = None
        if closed_loop:
            self.feedback = Feedback(len(rest), settings.feedback_gain, LARGEST * robot.size)
            self._measurements = inbox(self._measured_keys, settings.measurement_timeout)
            self._longest = settings.measurement_timeout
            self._measured_at = -np.inf

    def arrived(self, now: float, tick: int) -> bool:
        """Look for targets before the tick that is due; whether one has come for it."""
        self._record(self._targets.drain(now, self._looked), self._target_keys, tick)
        self._looked = True
        return self._targets.fresh

    def drain(self, now: float, tick: int) -> None:
        """Take targets and measurements in; those that are accepted go into the log as they came."""
        self._record(self._targets.drain(now, self._looked), self._target_keys, tick)
        self._looked = False
        if self._measurements is not None:
            self._record(self._measurements.drain(now), self._measured_keys, tick)

    def obey(self, command: Callable[[OperatorCommand], bool], tick: int) -> None:
        """Pass the operator's commands on; one that is not possible now counts as refused."""
        for word, payload, json in self._commands.drain():
            self._write(self._command_key, TEXT, payload, json, 0, tick)
            if command(word):
                self._commands.tally.accepted += 1
                if word is OperatorCommand.RESET and self.feedback is not None:
                    self.feedback.reset()
            else:
                self._commands.tally.refuse(
                    Rejection(RejectionReason.NOT_NOW, f"{word} is not possible now")
                )

    def goal(self, now: float, effectors: Array) -> Goal | None:
        """What is wanted; None when no target is young enough."""
        return self._targets.goal(now, effectors)

    def observe(self, now: float, effectors: Array) -> bool:
        """Correct by what was measured; False when a measurement that is needed is missing.

        Args:
            now: monotonic time [s].
            effectors: (p, 3) of the model [m].
        """
        if self._measurements is None or self.feedback is None:
            return True
        measured = self._measurements.complete(now)
        if measured is None:
            return False
        if self._measurements.fresh:
            seconds = min(now - self._measured_at, self._longest)
            self.feedback.observe(effectors, measured, seconds)
            self._measured_at = now
        return True

    def diagnostics(self) -> list[Diagnostic]:
        """Counts by what became of the messages."""
        found = [self._targets.tally.diagnostic("targets")]
        found.append(self._commands.tally.diagnostic("commands"))
        if self._measurements is not None:
            found.append(self._measurements.tally.diagnostic("measurements"))
        return found

    def _record(self, accepted: list[Received], keys: tuple[str, ...], tick: int) -> None:
        for item in accepted:
            json = item.encoding.startswith(JSON)
            self._write(keys[item.effector], POINT, item.payload, json, item.point.stamp, tick)

    def _write(self, key: str, kind: str, payload: bytes, json: bool, made: int, tick: int) -> None:
        if self._recorder is not None:
            seen = time.time_ns()
            self._recorder.write(Entry(key, kind, payload, json, seen, made or seen, tick))
