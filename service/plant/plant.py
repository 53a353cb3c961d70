"""A simulated robot in its own process: pointwise contact, driven by actuation."""

from __future__ import annotations

import gc
import logging
import time
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Literal

import numpy as np
import zenoh

from tauten.model import Robot, RobotFileError, Simulator, load_robot
from tauten.model.numerics import Array, FactorisationError
from tauten.service.node import Clock
from tauten.service.plant.drives import DrivenRobot, OwnSteps, own_steps
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
Steps = Literal["own", "single", "converged"]


@dataclass(frozen=True, slots=True)
class PlantSettings:
    """Settings of a plant.

    Attributes:
        measure: whether it also publishes its effectors as measurements, as a camera would.
        drive: whether its winches use pulled lengths or tensions.
        steps: "own", of second order and so short that their error is below half a per cent; one a period as
            the controller decides with, "single"; or one a period iterated to convergence, "converged".
    """

    measure: bool = False
    drive: Drive = "pull"
    steps: Steps = "own"


_HEALTH_PERIOD = 1.0  # s
_WARM_UP, _FEW = 12, 4  # periods
_MOST_LOAD = 0.5  # of the period, that steps of the full model may take for it to be chosen


@dataclass(frozen=True, slots=True)
class Warm:
    """A simulated robot that is ready to start.

    Attributes:
        driven: the robot, with every kernel compiled.
        own: its steps; None: one a period.
        seconds: median time of a period while it was warmed up.
        model: of what order it is, and the error that this makes.
    """

    driven: DrivenRobot
    own: OwnSteps | None
    seconds: float
    model: str

    @property
    def fields(self) -> dict[str, str]:
        """Its steps and its model, for health and logs."""
        found = {"model": self.model}
        if self.own is not None:
            found |= {
                "steps_per_period": str(self.own.count),
                "steps_error_percent": f"{100.0 * self.own.error:.2g}",
                "real_time_factor": f"{self.own.speed:.2g}",
            }
        return found


def plant_robot(
    robot: str, rate: float | None, model: Order | None, young_scale: float = 1.0
) -> tuple[Robot, str]:
    """The robot that a plant simulates, and of what order it is, with the error that this makes.

    In full order where this machine simulates that in half of the time that passes; otherwise reduced, which
    keeps the rate and has the reduction's error, still with pointwise contact.

    Args:
        robot: name of a shipped robot or path of a robot file.
        rate: another rate than the file's [Hz].
        model: "full" or "reduced", whatever the machine.
        young_scale: of Young's modulus; a robot of another stiffness than the file's has no state basis.

    Raises:
        RobotFileError, MeshError, StateBasisError: the robot cannot be loaded.
    """
    if young_scale != 1.0:
        if model == "reduced":
            raise RobotFileError(
                f"{robot}: --young-scale {young_scale:g} has no state basis; use --model full"
            )
        return load_robot(robot, rate=rate, young_scale=young_scale), "full"
    setup = load_setup(robot, rate, "none", model)
    if setup.states is None:
        return setup.robot, "full"
    if model is None:
        full = load_robot(robot, rate=rate)
        with one_blas_thread():
            if quick_enough(full):
                return full, "full"
    error = 1e3 * setup.states.origin.tip_max
    return (
        setup.robot,
        f"reduced, {setup.states.r} modes, tip within {error:.2g} mm on held-out paths",
    )


class Plant:
    """Steps a simulator at the control rate under the actuation that arrived last."""

    def __init__(
        self, robot: Robot, warm: Warm, session: zenoh.Session, settings: PlantSettings
    ) -> None:
        """Declare subscriber and publishers.

        Args:
            robot: that is simulated.
            warm: the simulation at its start.
            session: open Zenoh session.
            settings: of the plant.
        """
        keys = Keys(robot.name)
        self._robot = robot
        self._driven, self._simulator, self._fields = (
            warm.driven,
            warm.driven.simulator,
            warm.fields,
        )
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
        self._kind = settings.steps
        self._drive = settings.drive
        # what leads each actuator: efforts of those that a hold keeps by their effort
        self._by_force = robot.actuators.laws.held_by_force | (settings.drive == "tension")
        self._position: Array = np.where(self._by_force, np.nan, 0.0)
        self._effort: Array = np.where(self._by_force, 0.0, np.nan)
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
        position, effort = np.array(joints.position), np.array(joints.effort)  # (n_a,)
        self._position = np.where(self._by_force, np.nan, position)
        self._effort = np.where(self._by_force, effort, np.nan)

    def _advance(self) -> None:
        """One step; a simulation that blows up starts again."""
        try:
            if self._kind == "own":
                report = self._driven.move(self._position, self._effort)
            else:
                report = self._simulator.step(
                    position=self._position,
                    effort=self._effort,
                    converged=self._kind == "converged",
                )
            self._unconverged += not report.converged
        except FactorisationError as error:
            log.error("the simulation has blown up and starts again: %s", error)
            self._driven.reset()
            self._resets += 1

    def _publish(self) -> None:
        robot, simulator, stamp = self._robot, self._simulator, time.time_ns()
        layout, values = robot.effector_layout, simulator.effector_values
        for i, (kind, name) in enumerate(zip(layout.kinds, layout.names, strict=True)):
            own = tuple(values[layout.values_of(i)].tolist())
            payload = encode_effector(kind, name, EffectorMessage(stamp, robot.frame, own))
            for publishers in self._effectors:
                publishers[i].put(payload)
        position, effort = tuple(simulator.position.tolist()), tuple(simulator.effort.tolist())
        joints = Joints(stamp, robot.frame, robot.actuators.names, position, effort)
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
            | {"drive": self._drive, "steps": self._kind}
            | self._fields,
        )
        diagnostics = [loop, self._counts.diagnostic("actuation")]
        self._health.put(encode_health(time.time_ns(), self._robot.name, diagnostics))
        gc.collect()


def warm_simulator(robot: Robot, settings: PlantSettings) -> tuple[Simulator, float]:
    """A simulator with pointwise contact and every kernel it needs compiled, and the median of a period [s].

    It starts from the equilibrium under the robot's loads, as the node's model does, or from rest where
    there is none.

    Args:
        robot: that is simulated.
        settings: of the plant.
    """
    simulator, times = Simulator(robot, contact="full"), []
    way = robot.limits.rate * robot.h * _WARM_UP  # (n_a,)
    position = np.clip(robot.limits.farthest_position, -way, way)
    for step in range(_WARM_UP):
        begin, part = time.perf_counter(), position * (step + 1) / _WARM_UP
        try:
            if settings.steps == "own":
                simulator.move(position=part)
            else:
                simulator.step(position=part, converged=settings.steps == "converged")
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


def warm_plant(robot: Robot, settings: PlantSettings, model: str = "full") -> Warm:
    """A simulation that is ready to start, with the steps that its settings ask for.

    Args:
        robot: that is simulated.
        settings: of the plant.
        model: of what order it is, for health and logs.

    Raises:
        RobotFileError: time steps of this length lead to no state.
    """
    simulator, seconds = warm_simulator(robot, settings)
    if settings.steps != "own":
        return Warm(DrivenRobot(simulator, 1), None, seconds, model)
    own = own_steps(simulator)
    log.info(
        "%d steps a period of %g ms: twice as many move %s by %.2g %% of its way in a trial; %.2g times real "
        "time", own.count, 1e3 * robot.h, robot.name, 100.0 * own.error, own.speed,
    )  # fmt: skip
    return Warm(DrivenRobot(simulator, own.count), own, seconds, model)


def quick_enough(robot: Robot) -> bool:
    """Whether this machine simulates a robot in half of the time that passes, or in less."""
    simulator, times = Simulator(robot, contact="full"), []
    way = robot.limits.rate * robot.h  # (n_a,)
    position = np.clip(robot.limits.farthest_position, -way, way)
    for _ in range(_FEW):
        begin = time.perf_counter()
        simulator.move(position=position)
        times.append(time.perf_counter() - begin)
    seconds = min(times)
    log.info("%s in full order takes %.1f ms of %.1f ms", robot.name, 1e3 * seconds, 1e3 * robot.h)
    return seconds < _MOST_LOAD * robot.h


def simulate(
    robot: Robot, network: Network, settings: PlantSettings, stop: StopFlag, model: str = "full"
) -> None:
    """Simulate a robot until a request to stop.

    Args:
        robot: that is simulated.
        network: ports or configuration.
        settings: of the plant.
        stop: ends the plant, before its loop runs at once.
        model: of what order the robot is, and the error that this makes, for health and logs.

    Raises:
        NetworkError: no session.
        RobotFileError: time steps of this length lead to no state.
    """
    with ExitStack() as stack:
        stack.enter_context(one_blas_thread())
        with stop.interruptible():
            warm = warm_plant(robot, settings, model)
            typestore()
        session = open_session(network, Role.PLANT, robot.name)
        stack.callback(session.close)
        plant = Plant(robot, warm, session, settings)
        stack.enter_context(manual_garbage_collection())
        # the last before the loop: who waits for the plant starts to move the model
        token = session.liveliness().declare_token(Keys(robot.name).plant_token)
        stack.callback(token.undeclare)
        log.info("simulating %s at %g Hz", robot.name, 1.0 / robot.h)
        plant.run(stop)
