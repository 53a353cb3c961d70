"""Messages that arrive at a node: targets, commands, measurements, and a plant's messages for its log.

They wait in rings of Zenoh outside the interpreter: no Python code runs when one arrives, and the loop reads
them at its tick.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np
import zenoh

from tauten.controller import Controller
from tauten.model import Robot, extension_error, shape_fault
from tauten.model.contact import ObstaclePose
from tauten.model.numerics import Array
from tauten.service.log import Entry, LogRecorder, arrived, message_kinds
from tauten.service.node.estimator import Estimator, make_estimator
from tauten.service.node.feedback import LARGEST, Feedback, ModelHistory, capped, stable_gain
from tauten.service.node.plausibility import MeasurementCheck, Swing
from tauten.service.settings import ServiceSettings, lasting_timeout
from tauten.service.wire import (
    CDR,
    COMMAND_RING,
    EFFECTOR_RING,
    MESSAGE_TYPES,
    OBSTACLE_RING,
    TEXT,
    Cause,
    CommandSubscriber,
    Diagnostic,
    EffectorSubscriber,
    Keys,
    Level,
    ObstacleSubscriber,
    OperatorCommand,
    OperatorOrder,
    Received,
    Rejection,
    RejectionReason,
    as_cdr,
    quoted,
    reach_of,
)

log = logging.getLogger(__name__)

_PLANT_RING = 256
_LINE = 1.0  # s between two lines in the log about refused commands; health counts all of them
_AT_CAP = 0.99  # part of the largest correction from which on health warns


@dataclass(frozen=True, slots=True)
class Goal:
    """What to follow.

    Attributes:
        values: (n_v,) targets of the effectors, see `EffectorLayout`.
        correction: (n_e,) added to them in a closed loop; None in an open one.
        corrected: (n_v,) goal of the model.
        stamp: time in the header of the target that arrived last [ns since the epoch].
        delay: with which targets are interpolated [s]; 0: the latest are followed.
    """

    values: Array
    correction: Array | None
    corrected: Array
    stamp: int
    delay: float


class NodeInputs:
    """Reads what arrives for a node."""

    def __init__(
        self,
        session: zenoh.Session,
        robot: Robot,
        settings: ServiceSettings,
        closed_loop: bool,
        recorder: LogRecorder | None,
        period: float = 0.0,
    ) -> None:
        """Declare the subscribers.

        Args:
            session: open Zenoh session.
            robot: that is served.
            settings: timeouts, gain and delay.
            closed_loop: whether measurements correct the targets.
            recorder: of the log; None: none is kept.
            period: of the ticks, if another model with longer ones than the robot's may take over [s].
        """
        period = max(period, robot.h)
        keys, names, settings = Keys(robot.name), robot.effector_names, settings.lasting(period)
        rest, reach = robot.effector_values(robot.rest()), reach_of(robot.size)
        self._layout = layout = robot.effector_layout
        self._kinds = [MESSAGE_TYPES[kind] for kind in layout.kinds]

        def subscriber(
            of_effectors: tuple[str, ...], timeout: float, delay: float = 0.0
        ) -> EffectorSubscriber:
            rings = [
                session.declare_subscriber(key, zenoh.handlers.RingChannel(EFFECTOR_RING))
                for key in of_effectors
            ]
            return EffectorSubscriber(rings, robot.frame, layout, rest, reach, timeout, delay)

        self._recorder = recorder
        self._next_line = 0.0  # monotonic time [s]
        self._target_keys, self._measured_keys = keys.targets(names), keys.measurements(names)
        self._command_key = keys.command
        self._delay = settings.interpolation_delay
        self._targets = subscriber(self._target_keys, settings.target_timeout, self._delay)
        self._commands = CommandSubscriber(
            session.declare_subscriber(keys.command, zenoh.handlers.RingChannel(COMMAND_RING))
        )
        streams = {
            one.name: (
                session.declare_subscriber(
                    keys.obstacle(one.name), zenoh.handlers.RingChannel(OBSTACLE_RING)
                ),
                replace(one.stream, timeout=lasting_timeout(one.stream.timeout, period)),
            )
            for one in robot.obstacles.obstacles
            if one.stream is not None
        }
        deepest = robot.contacts.alarm_distance
        self._obstacles = ObstacleSubscriber(streams, robot.frame, deepest) if streams else None
        self._loop: MeasuredLoop | None = None
        if closed_loop:
            timeout = settings.measurement_timeout + settings.measurement_delay
            self._loop = MeasuredLoop(robot, settings, subscriber(self._measured_keys, timeout))
        self._plant = None
        if recorder is not None:
            self._plant = session.declare_subscriber(
                keys.plant, zenoh.handlers.RingChannel(_PLANT_RING)
            )
            self._message_kinds = message_kinds(keys, dict(zip(names, self._kinds, strict=True)))

    def read_targets(self, tick: int, late: float = 0.0) -> bool:
        """Read the targets that have arrived; whether any has since `take_fresh`.

        Args:
            tick: its number.
            late: how long ago it was due [s]; targets that have arrived since are those of the next tick.
        """
        accepted = self._targets.read(time.monotonic(), time.time(), late)
        self._record(accepted, self._target_keys, tick)
        return self._targets.fresh

    def take_fresh(self) -> bool:
        """Whether a target has arrived since the last call."""
        return self._targets.take_fresh()

    def goal(self, effectors: Array, late: float = 0.0) -> Goal | None:
        """The goal to follow; None when no target is young enough.

        Args:
            effectors: (n_v,) values of the model; goal of an effector whose target is not young enough,
                without correction: it would push the effector away from where it is.
            late: how long ago the tick was due, whose goal it is [s].
        """
        now = time.monotonic() - late
        values = self._targets.latest(now, effectors)
        if values is None:
            return None
        if self._loop is None:
            return Goal(values, None, values, self._targets.stamp, self._delay)
        followed = self._targets.followed(now)
        correction = np.where(followed, self._loop.correction, 0.0)
        corrected = self._layout.moved(values, correction)
        return Goal(values, correction, corrected, self._targets.stamp, self._delay)

    def read_commands(self, tick: int) -> list[OperatorOrder]:
        """Read the operator's commands, oldest first; `count` each when it has been carried out."""
        found = self._commands.read()
        for item in found:
            self._write(self._command_key, TEXT, item.payload, item.encoding, 0, tick)
        return [item.command for item in found]

    def count(self, command: OperatorOrder, refused: Rejection | None) -> None:
        """Count a command that was carried out, or that was refused."""
        if refused is not None:
            now = time.monotonic()
            # once of many in a row, and no more lines than can be read
            if refused.detail != self._commands.counts.last_rejection and now >= self._next_line:
                self._next_line = now + _LINE
                log.warning("refused the command %s: %s", quoted(command), refused.detail)
            self._commands.counts.refuse(refused)
            return
        self._commands.counts.accepted += 1
        if self._loop is not None:
            self._loop.after_command(command)

    def read_measurements(self, effectors: Array, following: bool, tick: int) -> Cause:
        """Read the measurements that have arrived and correct by them.

        Args:
            effectors: (n_v,) values of the model.
            following: whether the model follows the robot; in a stop it does not.
            tick: its number.

        Returns:
            `Cause.NONE`, or why the node cannot follow in a closed loop.
        """
        if self._loop is None:
            return Cause.NONE
        now = time.monotonic()
        accepted = self._loop.subscriber.read(now, time.time())
        self._record(accepted, self._measured_keys, tick)
        return self._loop.correct(now, effectors) if following else Cause.NONE

    def read_obstacles(self, controller: Controller) -> dict[str, ObstaclePose]:
        """Where obstacles are after the tick of which poses have arrived, or no longer do."""
        if self._obstacles is None:
            return {}
        now = time.monotonic(), time.time()
        return self._obstacles.read(*now, controller.robot.h, controller.depth_of)

    def record_plant(self, tick: int) -> None:
        """Write a plant's messages into the log; other messages on its keys are left out."""
        if self._plant is None:
            return
        for key, kind, payload in arrived(self._plant, self._message_kinds, _PLANT_RING):
            self._write(key, kind, payload, CDR, 0, tick)

    def diagnostics(self) -> list[Diagnostic]:
        """Counts of messages, and the state of a closed loop."""
        found = [self._of_targets()]
        found.append(self._commands.counts.diagnostic("commands"))
        if self._obstacles is not None:
            found.append(self._obstacles.diagnostic(time.monotonic()))
        if self._loop is not None:
            found.append(self._loop.subscriber.counts.diagnostic("measurements"))
            found.append(self._loop.diagnostic())
        return found

    def _of_targets(self) -> Diagnostic:
        """Counts of targets, and for which effectors they no longer arrive."""
        found = self._targets.counts.diagnostic("targets")
        values = {**found.values, "interpolation_delay_s": f"{self._delay:g}"}
        outdated = ", ".join(self._targets.outdated(time.monotonic()))
        if not outdated:
            return replace(found, values=values)
        message = f"too old: {outdated}; {found.message}"
        return Diagnostic(found.name, Level.WARN, message, {**values, "outdated": outdated})

    def _record(self, accepted: list[Received], keys: tuple[str, ...], tick: int) -> None:
        for item in accepted:
            kind, stamp = self._kinds[item.effector], item.message.stamp
            self._write(keys[item.effector], kind, item.payload, item.encoding, stamp, tick)

    def _write(
        self, key: str, kind: str, payload: bytes, encoding: str, made: int, tick: int
    ) -> None:
        if self._recorder is None:
            return
        read, message = time.time_ns(), as_cdr(payload, encoding, kind)
        if not isinstance(message, Rejection):
            self._recorder.write(Entry(key, kind, message, read, made or read, tick))


class MeasuredLoop:
    """Measurements of a closed loop: checked against the model, then turned into a correction.

    Attributes:
        subscriber: of the measurements.
        correction: (n_e,) added to the targets.
    """

    def __init__(
        self,
        robot: Robot,
        settings: ServiceSettings,
        subscriber: EffectorSubscriber,
        estimator: Estimator | None = None,
    ) -> None:
        """Start without a measurement; the estimator is by default the one that the settings name."""
        self.subscriber = subscriber
        self.correction: Array = np.zeros(robot.effector_layout.n_rows)
        self._estimator = used = estimator or make_estimator(robot, settings)
        given = stable_gain(settings.feedback_gain, settings.measurement_delay)
        self._gain = used.gain if isinstance(used, Feedback) else given  # 1/s
        self._layout, self._largest = robot.effector_layout, LARGEST * robot.size
        self._settings = settings
        self._delay = settings.measurement_delay
        self._timeout = settings.measurement_timeout
        self._check = MeasurementCheck(robot.effector_layout, robot.size, self._largest)
        self._swing = Swing(robot.effector_layout, robot.size)
        self._history = ModelHistory(self._layout)
        self._reason = ""  # why the last measurement was not plausible
        self._ignored = ""  # why the last correction was
        self._plausible = -np.inf  # monotonic time of the last plausible measurement [s]

    def correct(self, now: float, effectors: Array) -> Cause:
        """Correct by a measurement that has arrived, where the model has effectors (n_v,) now [s].

        Returns why the node cannot follow, or `Cause.NONE`.

        Raises:
            ExtensionError: the estimator has failed.
        """
        self._history.add(now, effectors)
        measured = self.subscriber.complete(now)
        if measured is None:
            return Cause.UNMEASURED
        if self.subscriber.take_fresh():
            made = [now - max(age, self._delay) for age in self.subscriber.ages(now)]
            model, seconds = self._history.at(made), now - self._plausible
            self._swing.add(now, model, measured)
            self._reason = self._check.reason(model, measured, seconds)
            if self._reason:
                rejection = Rejection(RejectionReason.NOT_PLAUSIBLE, self._reason)
                self.subscriber.counts.refuse(rejection)
            else:
                with self._named():
                    found = self._estimator.update(model, measured, min(seconds, self._timeout))
                self._ignored = self._fault(found)
                if not self._ignored:
                    self.correction = capped(self._layout, found, self._largest)
                self._plausible = now
        lasting = bool(self._reason) and now - self._plausible > self._timeout
        return Cause.IMPLAUSIBLE if self._check.fault or lasting else Cause.NONE

    def _fault(self, found: Array) -> str:
        """Why a correction is ignored; "" where it is not."""
        fault = shape_fault(("a correction", found, self.correction.shape))
        if not fault and np.isfinite(found).all():
            return ""
        return f"the estimator {fault or 'gives a correction that is not finite'}: it is ignored"

    @contextmanager
    def _named(self) -> Iterator[None]:
        """Name the estimator where it fails.

        Raises:
            ExtensionError: it does.
        """
        try:
            yield
        except Exception as error:
            raise extension_error(f"estimator {self._settings.estimator!r}", error) from error

    def after_command(self, command: OperatorOrder) -> None:
        """Start again after a reset, and after an enable where measurements were not plausible.

        Raises:
            ExtensionError: the estimator has failed.
        """
        fault = bool(self._check.fault) and command is OperatorCommand.ENABLE
        if fault or command is OperatorCommand.RESET:
            with self._named():
                self._estimator.reset()
            self.correction = np.zeros_like(self.correction)
            self._check.reset()
            self._swing.reset()
            self._reason = self._ignored = ""

    def diagnostic(self) -> Diagnostic:
        """Correction, its limit, and the age of the measurements."""
        age, largest = self.subscriber.oldest(time.monotonic()), self._largest
        length = float(self._layout.lengths(self.correction).max())
        at_cap = length >= _AT_CAP * largest
        warning = self._reason or self._ignored or "the correction is at its limit" * at_cap
        if extent := self._swing.extent:
            swings = f"the robot swings about its model by {1e3 * extent:.3g} mm"
            warning = (
                f"{swings}: has it less damping, or is feedback_gain too large? {warning}".rstrip()
            )
        values = {
            "correction_mm": f"{1e3 * length:.4g}",
            "largest_correction_mm": f"{1e3 * largest:.4g}",
            "age_s": f"{age:.3g}",
            "delay_s": f"{self._delay:g}",
            "estimator": self._settings.estimator,
            "gain": f"{self._gain:.4g}",
        }
        level = Level.WARN if warning else Level.OK
        return Diagnostic("feedback", level, warning or "plausible", values)
