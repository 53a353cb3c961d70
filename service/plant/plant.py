"""A simulated robot in its own process: pointwise contact, driven by actuation."""

from __future__ import annotations

import gc
import logging
import time
from contextlib import ExitStack
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import zenoh

from tauten.model import Robot, RobotFileError, Simulator, load_robot
from tauten.model.numerics import Array, FactorisationError
from tauten.model.simulation import Stepped
from tauten.service.node import Clock
from tauten.service.process import StopFlag, manual_garbage_collection, one_blas_thread
from tauten.service.setup import Order, load_setup, start_at_rest
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
    Role,
    Window,
    decode_joints,
    encode_effector,
    encode_float,
    encode_health,
    encode_joints,
    open_session,
    payload_of,
    typestore,
)

log = logging.getLogger(__name__)


Drive = Literal["pull", "tension"]
Steps = Literal["single", "converged", "auto"]


@dataclass(frozen=True, slots=True)
class PlantSettings:
    """Settings of a plant.

    Attributes:
        measure: whether it also publishes its effectors as measurements, as a camera would.
        drive: whether its winches use pulled lengths or tensions.
        steps: with a single linearisation, iterated to convergence, or "auto": converged where this machine
            is fast enough for the robot.
    """

    measure: bool = False
    drive: Drive = "pull"
    steps: Steps = "single"


_HEALTH_PERIOD = 1.0  # s
_WARM_UP = 12  # steps
_MOST_LOAD = 0.5  # of the period, that converged steps may take to be chosen


def plant_robot(
    robot: str, rate: float | None, model: Order | None, young_scale: float = 1.0
) -> Robot:
    """The robot that a plant simulates.

    Args:
        robot: name of a shipped robot or path of a robot file.
        rate: another rate than the file's [Hz].
        model: another model than the file's. A reduced one lets a plant keep the rate where the full one is
            too slow; it then has the reduction's error, but still pointwise contact.
        young_scale: of Young's modulus; a robot of another stiffness than the file's has no state basis.

    Raises:
        RobotFileError, MeshError, StateBasisError: the robot cannot be loaded.
    """
    if young_scale != 1.0:
        if model == "reduced":
            raise RobotFileError(
                f"{robot}: --young-scale {young_scale:g} has no state basis; use --model full"
            )
        return load_robot(robot, rate=rate, young_scale=young_scale)
    return load_setup(robot, rate, "none", model).robot


class Plant:
    """Steps a simulator at the control rate under the actuation that arrived last."""

    def __init__(
        self, robot: Robot, simulator: Simulator, session: zenoh.Session, settings: PlantSettings
    ) -> None:
        """Declare subscriber and publishers.

        Args:
            robot: that is simulated.
            simulator: at its start and warm.
            session: open Zenoh session.
            settings: of the plant.
        """
        keys = Keys(robot.name)
        self._robot = robot
        self._simulator = simulator
        # only the latest actuation is used
        self._source = session.declare_subscriber(keys.actuation, zenoh.handlers.RingChannel(1))
        self._state = Publisher(session, keys.plant_state, JOINTS)
        names, kinds = robot.effector_names, robot.effector_layout.kinds
        groups = [keys.plant_effectors(names)] + [keys.measurements(names)] * settings.measure
        self._effectors = [
            [
                Publisher(session, key, MESSAGE_TYPES[kind])
                for key, kind in zip(group, kinds, strict=True)
            ]
            for group in groups
        ]
        self._gap = Publisher(session, keys.plant_gap, FLOAT)
        self._health = Publisher(session, keys.plant_health, HEALTH, urgent=False)
        self._converged = settings.steps == "converged"
        self._drive = settings.drive
        # what leads each actuator: efforts of those that a hold keeps by their effort
        self._by_force = robot.actuators.held_by_force | (settings.drive == "tension")
        self._pull: Array = np.where(self._by_force, np.nan, 0.0)
        self._tension: Array = np.where(self._by_force, 0.0, np.nan)
        self._counts = MessageCounts()
        self._step = Window()
        self._unconverged = 0
        self._resets = 0
        self._next_health = 0.0

    def run(self, stop: StopFlag) -> None:
        """Step until a request to stop; steps that are late are skipped, not queued."""
        clock = Clock(self._robot.h)
        while not stop.requested:
            clock.wait()
            self._read_actuation()
            begin = time.perf_counter()
            self._advance()
            self._step.add(time.perf_counter() - begin)
            self._publish()
            self._housekeeping(clock)

    def _read_actuation(self) -> None:
        """Use the latest actuation, if it is valid."""
        sample = self._source.try_recv()
        if sample is None:
            return
        payload, names = payload_of(sample), self._robot.actuators.names
        if isinstance(payload, Rejection):
            self._counts.refuse(payload)
            return
        joints = decode_joints(payload, str(sample.encoding), names)
        if isinstance(joints, Rejection):
            self._counts.refuse(joints)
            return
        self._counts.accepted += 1
        pull, tension = np.array(joints.pull), np.array(joints.tension)  # (n_a,)
        self._pull = np.where(self._by_force, np.nan, pull)
        self._tension = np.where(self._by_force, tension, np.nan)

    def _advance(self) -> None:
        """One step; a simulation that blows up starts again."""
        try:
            report = self._simulator.step(
                pull=self._pull, tension=self._tension, converged=self._converged
            )
            self._unconverged += not report.converged
        except FactorisationError as error:
            log.error("the simulation has blown up and starts again: %s", error)
            self._simulator.reset()
            self._resets += 1

    def _publish(self) -> None:
        robot, simulator, stamp = self._robot, self._simulator, time.time_ns()
        layout, values = robot.effector_layout, simulator.effector_values
        for i, (kind, name) in enumerate(zip(layout.kinds, layout.names, strict=True)):
            own = tuple(values[layout.values_of(i)].tolist())
            payload = encode_effector(kind, name, EffectorMessage(stamp, robot.frame, own))
            for publishers in self._effectors:
                publishers[i].put(payload)
        pull, tension = tuple(simulator.pull.tolist()), tuple(simulator.tension.tolist())
        joints = Joints(stamp, robot.frame, robot.actuators.names, pull, tension)
        self._state.put(encode_joints(joints))
        self._gap.put(encode_float(float(simulator.gaps.min(initial=np.inf))))

    def _housekeeping(self, clock: Clock) -> None:
        now = time.monotonic()
        if now < self._next_health:
            return
        self._next_health = now + _HEALTH_PERIOD
        counts = {
            "skipped": clock.skipped,
            "unconverged": self._unconverged,
            "resets": self._resets,
        }
        loop = Diagnostic(
            "plant",
            Level.WARN if any(counts.values()) else Level.OK,
            ", ".join(f"{count} {name}" for name, count in counts.items()),
            {key: str(count) for key, count in counts.items()}
            | self._step.entries("step_ms", 1e3)
            | {"drive": self._drive, "steps": "converged" if self._converged else "single"},
        )
        diagnostics = [loop, self._counts.diagnostic("actuation")]
        self._health.put(encode_health(time.time_ns(), self._robot.name, diagnostics))
        gc.collect()


def warm_simulator(robot: Robot, converged: bool) -> tuple[Simulator, float]:
    """A full-order simulator with every kernel it needs compiled, and the median of a step [s].

    It starts from the equilibrium under the robot's loads, as the node's model does, or from rest where
    there is none.

    Args:
        robot: that is simulated.
        converged: whether its steps are iterated to convergence.
    """
    simulator, times = Simulator(robot, contact="full"), []
    way = robot.limits.rate * robot.h * _WARM_UP  # (n_a,)
    pull = np.clip(robot.limits.farthest_pull, -way, way)
    for step in range(_WARM_UP):
        begin = time.perf_counter()
        try:
            simulator.step(pull=pull * (step + 1) / _WARM_UP, converged=converged)
        except FactorisationError as error:
            raise RobotFileError(
                f"robot {robot.name}: time steps of {robot.h:g} s, in which an actuator may travel far, "
                f"lead to no state ({error}); choose a larger controller.rate"
            ) from error
        times.append(time.perf_counter() - begin)
    report = simulator.settle_start()
    if not report.converged:
        log.warning("%s", start_at_rest(robot, report))
    return simulator, float(np.median(times))


def chosen_steps(robot: Robot, settings: PlantSettings) -> tuple[Simulator, PlantSettings]:
    """A warm simulator, and the settings with the steps that "auto" stands for.

    Args:
        robot: that is simulated.
        settings: of the plant.

    Raises:
        RobotFileError: the robot has no converged steps.
    """
    if settings.steps != "single" and not isinstance(robot, Stepped):
        if settings.steps == "converged":
            raise RobotFileError(
                f"robot {robot.name}: steps are converged, a robot with drives, rigid regions or attachments "
                "has only single ones"
            )
        settings = replace(settings, steps="single")
    simulator, duration = warm_simulator(robot, settings.steps != "single")
    if settings.steps != "auto":
        return simulator, settings
    enough = duration < _MOST_LOAD * robot.h
    log.info(
        "a converged step takes %.1f ms of %.1f ms: steps are %s", 1e3 * duration, 1e3 * robot.h,
        "converged" if enough else "linearised once",
    )  # fmt: skip
    return simulator, replace(settings, steps="converged" if enough else "single")


def simulate(robot: Robot, network: Network, settings: PlantSettings, stop: StopFlag) -> None:
    """Simulate a robot until a request to stop.

    Args:
        robot: that is simulated.
        network: ports or configuration.
        settings: of the plant.
        stop: ends the plant, before its loop runs at once.

    Raises:
        NetworkError: no session.
        RobotFileError: the robot has no converged steps.
    """
    with ExitStack() as stack:
        stack.enter_context(one_blas_thread())
        with stop.interruptible():
            simulator, settings = chosen_steps(robot, settings)
            typestore()
        session = open_session(network, Role.PLANT, robot.name)
        stack.callback(session.close)
        plant = Plant(robot, simulator, session, settings)
        stack.enter_context(manual_garbage_collection())
        # the last before the loop: who waits for the plant starts to move the model
        token = session.liveliness().declare_token(Keys(robot.name).plant_token)
        stack.callback(token.undeclare)
        log.info("simulating %s at %g Hz", robot.name, 1.0 / robot.h)
        plant.run(stop)
