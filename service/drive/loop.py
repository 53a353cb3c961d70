"""The loop of a driver: actuation from the node to the driver, what it measures to the network.

What arrives is checked again: only finite values of this robot's actuators reach a driver, clipped to the
limits of the description. When no actuation arrives for `SILENCE` periods, the driver is deactivated until
one does.
"""

from __future__ import annotations

import gc
import logging
import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import replace

import numpy as np
import zenoh

from tauten.model import extension_error, is_own
from tauten.model.numerics import Array
from tauten.service.drive.driver import Driver, DriverError, Measured
from tauten.service.link import announced
from tauten.service.node import Clock
from tauten.service.process import Interrupted, StopFlag, manual_garbage_collection
from tauten.service.wire import (
    FLOAT,
    HEALTH,
    JOINTS,
    MESSAGE_TYPES,
    Diagnostic,
    EffectorMessage,
    Joints,
    Keys,
    Level,
    MessageCounts,
    Network,
    Publisher,
    Rejection,
    RobotDescription,
    Role,
    Window,
    ask_description,
    check_node,
    decode_joints,
    encode_effector,
    encode_float,
    encode_health,
    encode_joints,
    payload_of,
    places_of,
    session_of,
    typestore,
    wait_for,
)

log = logging.getLogger(__name__)

SILENCE = 10  # periods without an actuation, after which a driver is deactivated
_LEAST_SILENCE = 0.2  # s
_HEALTH_PERIOD = 1.0  # s
# s for which a call of a driver may last after a request to stop, and `deactivate`, which may move the robot
_PATIENCE, _LONGEST_DEACTIVATION = 1.0, 10.0


def driver_failure(robot: str, what: str) -> DriverError:
    """The error of a robot's driver that fails."""
    return DriverError(f"the driver of {robot} fails: {what}")


@contextmanager
def hardware_of(robot: str, driver: Driver) -> Iterator[None]:
    """Name the driver of a robot where its hardware fails, or its code, which is that of another package.

    Raises:
        DriverError: its hardware does.
        ExtensionError: its code does.
    """
    try:
        yield
    except DriverError:
        raise
    except OSError as error:
        raise driver_failure(robot, str(error)) from error
    except Exception as error:
        if is_own(driver):
            raise
        raise extension_error(f"the driver of {robot}", error) from error


class DriveLoop:
    """Runs a configured driver at the control rate.

    Attributes:
        active: whether the driver follows.
    """

    def __init__(
        self, session: zenoh.Session, robot: RobotDescription, driver: Driver, measure: bool
    ) -> None:
        """Declare subscriber and publishers.

        With `measure` effectors are also published as measurements, which correct a closed loop.
        """
        keys, names = Keys(robot.name), robot.effector_names
        self._session, self._robot, self._driver = session, robot, driver
        self._names = tuple(one.name for one in robot.actuators)
        self._places = places_of(robot.effectors)
        self._n_v = max((place.stop for place in self._places), default=0)
        limits = np.array([(one.position, one.effort) for one in robot.actuators])  # (n_a, 2, 2)
        self._position_limits, self._effort_limits = limits[:, 0].T, limits[:, 1].T
        # only the latest actuation is used
        self._source = session.declare_subscriber(keys.actuation, zenoh.handlers.RingChannel(1))
        self._state = Publisher(session, keys.plant_state, JOINTS)
        groups = [keys.plant_effectors(names)] + [keys.measurements(names)] * measure
        self._effectors = [
            [Publisher(session, group[i], MESSAGE_TYPES[one.kind]) for group in groups]
            for i, one in enumerate(robot.effectors)
        ]
        self._gap = Publisher(session, keys.plant_gap, FLOAT)
        self._health = Publisher(session, keys.plant_health, HEALTH, urgent=False)
        self._counts, self._step = MessageCounts(), Window()
        self._silence = max(SILENCE / robot.rate, _LEAST_SILENCE)  # s
        self._heard = 0.0  # monotonic time of the last actuation [s]
        self._next_health = 0.0
        self._stop = StopFlag()
        self.active = False

    def run(self, stop: StopFlag) -> None:
        """Run until a request to stop, then deactivate; periods that are late are skipped, not queued.

        Raises:
            DriverError: the hardware fails.
            ExtensionError: the code of the driver does.
            NetworkError: the node serves another robot.
            Interrupted: a call of the driver has not ended after a request to stop.
        """
        self._stop = stop
        try:
            self._run_and_pause()
        except Interrupted:
            log.warning(
                "a call of the driver of %s has not ended: it is interrupted", self._robot.name
            )
            raise

    def _run_and_pause(self) -> None:
        clock = Clock(1.0 / self._robot.rate)
        try:
            with self._stop.interruptible(_PATIENCE):
                while not self._stop.requested:
                    clock.wait()
                    self.tick(clock)
        finally:
            wanted = self._stop.requested
            self._pause("the loop has ended", logging.INFO if wanted else logging.WARNING)

    def tick(self, clock: Clock) -> None:
        """One period.

        Raises:
            DriverError: the hardware fails.
            ExtensionError: the code of the driver does.
            NetworkError: the node that speaks serves another robot.
        """
        actuation = self._read_actuation()
        begin = time.perf_counter()
        if actuation is not None:
            if not self.active:
                check_node(self._session, self._robot)
            position = np.clip(np.array(actuation.position), *self._position_limits)
            effort = np.clip(np.array(actuation.effort), *self._effort_limits)
            with hardware_of(self._robot.name, self._driver):
                if not self.active:
                    self.active = True  # from when on the driver has to be deactivated
                    self._driver.activate()
                self._driver.write(position, effort)
            self._heard = time.monotonic()
        elif self.active and time.monotonic() - self._heard > self._silence:
            self._pause(f"no actuation for {self._silence:g} s")
        measured = self._measured()
        self._step.add(time.perf_counter() - begin)
        self._publish(measured)
        self._report(clock, measured)

    def _measured(self) -> Measured:
        """What the driver reads.

        Raises:
            DriverError: that is no measurement of this robot.
        """
        with hardware_of(self._robot.name, self._driver):
            found: object = self._driver.read()
        if not isinstance(found, Measured):
            raise self._failure(f"its read() returns {type(found).__name__}, expected Measured")
        for name, given, kind in (
            ("facts", found.facts, Mapping),
            ("warning", found.warning, str),
        ):
            if not isinstance(given, kind):
                said = f"{name} of type {type(given).__name__}, expected {kind.__name__}"
                raise self._failure(f"its read() gives {said}")
        n_a, effectors, gap = len(self._names), found.effectors, found.gap
        if effectors is not None:
            effectors = self._checked("effectors", effectors, (self._n_v,))
        return replace(
            found,
            position=self._checked("position", found.position, (n_a,)),
            effort=self._checked("effort", found.effort, (n_a,)),
            effectors=effectors,
            gap=None if gap is None else float(self._checked("gap", gap, ())),
        )

    def _checked(self, name: str, values: object, shape: tuple[int, ...]) -> Array:
        """What is measured of this name, as an array of this shape.

        Raises:
            DriverError: it is none.
        """
        try:
            array = np.asarray(values, float)
        except (TypeError, ValueError) as error:
            raise self._failure(f"its read() gives {name}: {error}") from error
        if array.shape != shape:
            raise self._failure(f"its read() gives {name} of shape {array.shape}, expected {shape}")
        return array

    def _failure(self, what: str) -> DriverError:
        return driver_failure(self._robot.name, what)

    def _pause(self, why: str, level: int = logging.WARNING) -> None:
        if self.active:
            self.active = False
            log.log(level, "%s: the driver of %s is deactivated", why, self._robot.name)
            patience = self._stop.interruptible(_LONGEST_DEACTIVATION)
            with patience, hardware_of(self._robot.name, self._driver):
                self._driver.deactivate()

    def _read_actuation(self) -> Joints | None:
        """The latest actuation, if one has arrived that is valid."""
        sample = self._source.try_recv()
        if sample is None:
            return None
        payload = payload_of(sample)
        if not isinstance(payload, Rejection):
            joints = decode_joints(payload, str(sample.encoding), self._names)
            if not isinstance(joints, Rejection):
                self._counts.accepted += 1
                return joints
            payload = joints
        self._counts.refuse(payload)
        return None

    def _publish(self, measured: Measured) -> None:
        """What is measured; values that are not finite leave out positions, efforts, or an effector."""
        robot, stamp = self._robot, time.time_ns()
        if measured.effectors is not None:
            for one, place, publishers in zip(
                robot.effectors, self._places, self._effectors, strict=True
            ):
                own = measured.effectors[place]
                if np.isfinite(own).all():
                    message = EffectorMessage(stamp, robot.frame, tuple(own.tolist()))
                    payload = encode_effector(one.kind, one.name, message)
                    for publisher in publishers:
                        publisher.put(payload)
        position, effort = (
            tuple(values.tolist()) if np.isfinite(values).all() else ()
            for values in (measured.position, measured.effort)
        )
        self._state.put(encode_joints(Joints(stamp, robot.frame, self._names, position, effort)))
        if measured.gap is not None:
            self._gap.put(encode_float(measured.gap))

    def _report(self, clock: Clock, measured: Measured) -> None:
        """Health, and garbage, once a second."""
        now = time.monotonic()
        if now < self._next_health:
            return
        self._next_health = now + _HEALTH_PERIOD
        warning = f", {measured.warning}" if measured.warning else ""
        loop = Diagnostic(
            "plant",
            Level.WARN if clock.skipped or warning else Level.OK,
            f"{'active' if self.active else 'not active'}, {clock.skipped} skipped{warning}",
            {"active": str(self.active).lower(), "skipped": str(clock.skipped)}
            | self._step.entries("step_ms", 1e3)
            | {name: str(fact) for name, fact in measured.facts.items()},
        )
        diagnostics = [loop, self._counts.diagnostic("actuation")]
        self._health.put(encode_health(time.time_ns(), self._robot.name, diagnostics))
        gc.collect()


def run_driver(
    session: zenoh.Session, robot: RobotDescription, driver: Driver, measure: bool, stop: StopFlag
) -> None:
    """Announce the robot and run its driver until a request to stop.

    Raises:
        DriverError: the hardware fails.
        ExtensionError: the code of the driver does.
        NetworkError: the node serves another robot.
    """
    loop = DriveLoop(session, robot, driver, measure)
    # the token is the last before the loop: who waits for the plant starts to move the model
    with manual_garbage_collection(), announced(session, Keys(robot.name).plant_token):
        log.info("driving %s at %g Hz", robot.name, robot.rate)
        loop.run(stop)


def drive(
    robot: str, driver: Driver, options: Mapping[str, str], network: Network, stop: StopFlag
) -> None:
    """Run a driver beside the node that serves a robot, once that is alive.

    Raises:
        NetworkError: no session, no description, or later a node that serves another robot.
        DriverError: the hardware cannot be used, or fails.
        ExtensionError: the code of the driver fails.
    """
    keys = Keys(robot)
    with ExitStack() as stack:
        with stop.interruptible():
            session = stack.enter_context(session_of(network, Role.PLANT, robot))
        if not wait_for(session, keys.token, stop):
            return
        description = ask_description(session, keys)
        with stop.interruptible(), hardware_of(robot, driver):
            driver.configure(description, options)
        typestore()
        run_driver(session, description, driver, True, stop)
