"""A simulated robot in its own process: pointwise contact, driven by actuation."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import zenoh

from tauten.controller import Order, start_at_rest
from tauten.model import Command, Robot, RobotFileError, Simulator, one_blas_thread
from tauten.model.body import SparseBody
from tauten.model.numerics import Array, FactorisationError
from tauten.service.describing import describe
from tauten.service.drive import Measured, run_driver
from tauten.service.plant.drives import Drive, DrivenRobot, OwnSteps, own_steps, yielding
from tauten.service.process import StopFlag
from tauten.service.setup import Setup, load_setup
from tauten.service.wire import (
    Keys,
    Network,
    ObstacleState,
    Ring,
    RobotDescription,
    Role,
    decode_obstacle,
    payload_of,
    session_of,
    typestore,
)

log = logging.getLogger(__name__)


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


_WARM_UP, _FEW = 12, 4  # periods
_LEAST = 2  # time steps
_PRODUCTS = 20  # of its matrix and a vector, which a time step takes longer than: it is factorised
_MOST_LOAD = 0.5  # of the period, that steps of the full model may take for it to be chosen


@dataclass(frozen=True, slots=True)
class Warm:
    """A simulated robot that is ready to start.

    Attributes:
        driven: the robot, with every kernel compiled.
        own: its steps; None: one a period.
        model: of what order it is, and the error that this makes.
    """

    driven: DrivenRobot
    own: OwnSteps | None
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
) -> Setup:
    """Load the robot that a plant simulates.

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
        model = "full"
    return load_setup(robot, rate, "none", model, young_scale=young_scale)


def plant_setup(setup: Setup, model: Order | None) -> tuple[Setup, str]:
    """The robot in the order in which it is simulated, and a text of which that is, with its error.

    In full order where this machine simulates that in half of the time that passes; otherwise reduced, which
    keeps the rate and has the reduction's error, still with pointwise contact.
    """
    setup = replace(setup, contact="none", basis_name="none")
    if not setup.states:
        return setup, "full"
    if model is None:
        full = setup.in_full_order()
        with one_blas_thread():
            if quick_enough(full.robot):
                return full, "full"
    error = 1e3 * max(basis.origin.tip_max for basis in setup.states)
    modes = sum(basis.r for basis in setup.states)
    return (
        setup,
        f"reduced, {modes} modes, tip within {error:.2g} mm on held-out paths",
    )


class SimulatedDriver:
    """A simulated robot as a driver: each reading comes after a period of simulation."""

    def __init__(self, warm: Warm, settings: PlantSettings) -> None:
        self._driven, self._simulator = warm.driven, warm.driven.simulator
        robot, self._kind = self._simulator.robot, settings.steps
        self._facts = {"drive": settings.drive, "steps": settings.steps, **warm.fields}
        # what leads each actuator: efforts of those that a hold keeps by their effort
        self._by_force = robot.actuators.laws.held_by_force | (settings.drive == "tension")
        zero = np.zeros(robot.n_a)
        self.write(zero, zero)
        self._unconverged = 0
        self._resets = 0
        self._obstacles: dict[str, Ring] = {}

    def configure(self, robot: RobotDescription, options: Mapping[str, str]) -> None:
        """Nothing: a simulation is made from a model."""

    def activate(self) -> None:
        """Nothing: it moves under its loads from the start."""

    def deactivate(self) -> None:
        """Nothing: its winches hold what was written last."""

    def follow(self, session: zenoh.Session) -> None:
        """Have the obstacles that move where the node's model has them; without a node they move on."""
        robot = self._simulator.robot
        keys = Keys(robot.name)
        self._obstacles = {
            one.name: session.declare_subscriber(
                keys.obstacle_state(one.name), zenoh.handlers.RingChannel(1)
            )
            for one in robot.obstacles.obstacles
            if one.may_move
        }

    def write(self, position: Array, effort: Array) -> None:
        """Follow an actuation from the next reading on."""
        self._given = Command.either(self._by_force, position, effort)

    def read(self) -> Measured:
        """The robot after another period."""
        self._advance()
        simulator = self._simulator
        counts = {"unconverged": self._unconverged, "resets": self._resets}
        return Measured(
            simulator.position,
            simulator.effort,
            simulator.effector_values,
            float(simulator.gaps.min(initial=np.inf)),
            {name: str(count) for name, count in counts.items()} | self._facts,
            ", ".join(f"{count} {name}" for name, count in counts.items() if count),
        )

    def _place_obstacles(self) -> None:
        """Put obstacles where the node's model has them."""
        for name, ring in self._obstacles.items():
            sample = ring.try_recv()
            payload = None if sample is None else payload_of(sample)
            if isinstance(payload, bytes):
                state = decode_obstacle(payload)
                if isinstance(state, ObstacleState):
                    # where it is after the period that follows, at whose start the simulation is
                    before = state.pose.after(-self._simulator.robot.h)
                    poses = self._simulator.obstacles.with_pose(name, before)
                    self._simulator.set_obstacles(poses)

    def _advance(self) -> None:
        """One period; a simulation that blows up starts again."""
        self._place_obstacles()
        position, effort = self._given.position, self._given.effort
        try:
            if self._kind == "own":
                report = self._driven.move(position, effort)
            else:
                converged = self._kind == "converged"
                report = self._simulator.step(position, effort, converged=converged)
            self._unconverged += not report.converged
        except FactorisationError as error:
            log.error("the simulation has blown up and starts again: %s", error)
            self._driven.reset()
            self._resets += 1


def warm_simulator(robot: Robot, settings: PlantSettings) -> Simulator:
    """A simulator with pointwise contact and every kernel it needs compiled.

    It starts from the equilibrium under the robot's loads, as the node's model does, or from rest where
    there is none.
    """
    simulator = Simulator(robot, contact="full")
    for step in range(_WARM_UP):
        given = _first_moved(robot, step + 1)
        try:
            if settings.steps == "own":
                simulator.move(given.position, given.effort)
            else:
                converged = settings.steps == "converged"
                simulator.step(given.position, given.effort, converged=converged)
        except FactorisationError as error:
            raise RobotFileError(
                f"robot {robot.name}: time steps of {robot.h:g} s, in which an actuator may travel far, "
                f"lead to no state ({error}); choose a larger controller.rate"
            ) from error
    report = simulator.settle_start()
    if not report.converged:
        log.warning("%s", start_at_rest(robot, report))
    return simulator


def warm_plant(robot: Robot, settings: PlantSettings, model: str = "full") -> Warm:
    """A simulation that is ready to start, with the steps that its settings ask for.

    Raises:
        RobotFileError: time steps of this length lead to no state.
    """
    simulator = warm_simulator(robot, settings)
    if settings.steps != "own":
        return Warm(DrivenRobot(simulator, 1), None, model)
    own = own_steps(simulator)
    log.info(
        "%d step%s a period of %g ms: twice as many move %s by %.2g %% of its way in a trial; %.2g times "
        "real time", own.count, "s"[: own.count > 1], 1e3 * robot.h, robot.name, 100.0 * own.error, own.speed,
    )  # fmt: skip
    return Warm(DrivenRobot(simulator, own.count), own, model)


def quick_enough(robot: Robot) -> bool:
    """Whether this machine simulates a robot in half of the time that passes, or in less.

    A period has at least one time step: where that alone takes longer, no period is tried; and no step where
    a part of it surely takes longer.
    """
    if _PRODUCTS * _product_seconds(robot) > _MOST_LOAD * robot.h:
        return False
    simulator, given = Simulator(robot, contact="full"), _first_moved(robot, 1)
    seconds = _least_time(lambda: simulator.step(given.position, given.effort), _LEAST)
    if seconds < _MOST_LOAD * robot.h:
        simulator.reset()
        seconds = _least_time(lambda: simulator.move(given.position, given.effort), _FEW)
    log.info("%s in full order takes %.1f ms of %.1f ms", robot.name, 1e3 * seconds, 1e3 * robot.h)
    return seconds < _MOST_LOAD * robot.h


def _first_moved(robot: Robot, periods: int) -> Command:
    """The command that moves the first actuator for some periods from rest; cables are slack meanwhile.

    Cables that oppose each other cannot all be wound: it would compress the robot.
    """
    way, none = periods * robot.h * robot.limits.rate[0], np.zeros(robot.n_a)
    given = Command.either(yielding(robot), none, none)
    given.position[0] = np.clip(robot.limits.farthest_position[0], -way, way)
    given.effort[0] = np.nan
    return given


def _product_seconds(robot: Robot) -> float:
    """Time of a product of the matrix of a step, which is sparse in full order, with a vector [s]."""
    body = robot.body
    if not isinstance(body, SparseBody):
        return 0.0
    matrix = body.pattern.matrix(np.ones(body.stored_shape))
    return _least_time(lambda: matrix @ np.ones(body.n), _FEW)


def _least_time(work: Callable[[], object], count: int) -> float:
    """The shortest time of several calls [s]; kernels are compiled or loaded in the first."""
    times = []
    for _ in range(count):
        begin = time.perf_counter()
        work()
        times.append(time.perf_counter() - begin)
    return min(times)


def simulate(
    setup: Setup, network: Network, settings: PlantSettings, stop: StopFlag, model: Order | None
) -> None:
    """Simulate a robot until a request to stop; `model` is its order, see `plant_setup`.

    Raises:
        NetworkError: no session, or the node serves another robot.
        RobotFileError: time steps of this length lead to no state.
    """
    with ExitStack() as stack:
        stack.enter_context(one_blas_thread())
        with stop.interruptible():
            # before what takes seconds: its port may be taken
            session = stack.enter_context(session_of(network, Role.PLANT, setup.robot.name))
            log.info("the simulated robot gets ready")  # its kernels may have to be compiled
            setup, order = plant_setup(setup, model)
            warm = warm_plant(setup.robot, settings, order)
            typestore()
        driver = SimulatedDriver(warm, settings)
        driver.follow(session)
        run_driver(session, describe(setup), driver, settings.measure, stop)
