"""`python -m benchmarks still`: whether robots rest at constant targets, where, and whether they get stuck.

Random targets within twice the workspace: effectors at random equilibria, and up to twice as far away.
In closed loop the robot is the same model under a tenth more gravity, which the controller does not know, and
a run is as much longer as the correction takes to become constant.

How long a robot takes to rest depends on its own damping, whatever moves it. So each run is compared with
another one, in which the actuators go to the same place as fast as they may and stay there.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from itertools import tee
from time import monotonic
from typing import Literal

import numpy as np
from scipy.optimize import least_squares

from benchmarks.control.orders import OrderRun, order_run
from tauten.controller import Actuation, Controller, Order
from tauten.model import Command, Robot, Simulator, one_blas_thread
from tauten.model.numerics import Array, FactorisationError
from tauten.service.node import Feedback, own_estimator
from tauten.service.plant import DrivenRobot
from tauten.service.process import HostInfo, Interrupted, Progress, StopFlag, host_info
from tauten.service.setup import Setup, load_setup

Loop = Literal["open", "closed"]

SHIPPED = (
    "finger", "trunk", "diamond", "pneumatic_finger", "gripper", "tripod", "accordion", "manipulator",
)  # fmt: skip
RESTING = 1e-6  # of the range of a position or an effort
STANDING = 0.1  # of that, in the last part of a run that need not go on
LAST = 1.0  # s, part of a run that is to be at rest
NEAR = 0.01  # of the best error, within which an error is as good as it, and
CLOSE = 1e-3  # of the way to the target, by which the energy of the actuators may hold a robot back
LEAST = 1e-6  # of the robot's size, what counts as no error
DESCENT = 6  # linearisations at most, from where the robot rests
STIFF = 30.0  # weight of efforts beyond their limits in it, relative to the error
HEAVIER = 1.1  # gravity of the robot in closed loop


@dataclass(frozen=True, slots=True)
class StillSettings:
    """What is measured.

    Attributes:
        robots: names or files.
        models: "full" and "reduced".
        targets: of each robot, model, loop and contact, where the time is enough.
        orders: random locks, holds, unlocks and targets of each robot; 0: none.
        seconds: of each run in open loop, at most.
        seed: of targets and orders.
        minutes: for the targets of each robot and model, shared equally among loops and contact.
    """

    robots: tuple[str, ...] = SHIPPED
    models: tuple[Order, ...] = ("reduced",)
    targets: int = 10
    orders: int = 400
    seconds: float = 8.0
    seed: int = 0
    minutes: float = 10.0


@dataclass(frozen=True, slots=True)
class StillRun:
    """A run to a constant target.

    Attributes:
        robot: name.
        model: "full" or "reduced".
        loop: "open" or "closed".
        contact: whether the controller has contact.
        offset_mm: distance of the target from the start.
        position: largest change of a position in the last part, relative to its range.
        effort: that of an effort.
        error_mm: distance of the robot from the target at the end.
        best_mm: least distance that a descent over equilibria finds from there; None in closed loop.
        statuses: of the last part.
        rest_s: time from the last tick at a rate limit until all stays within `RESTING`; None: never.
        own_rest_s: the same of the robot whose actuators go to the same place as fast as they may and stay;
            None: never, and in closed loop.
        size_mm: of the robot.
    """

    robot: str
    model: Order
    loop: Loop
    contact: bool
    offset_mm: float
    position: float
    effort: float
    error_mm: float
    best_mm: float | None
    statuses: tuple[str, ...]
    rest_s: float | None
    own_rest_s: float | None
    size_mm: float

    @property
    def rests(self) -> bool:
        """Whether it is at rest."""
        return self.position <= RESTING and self.effort <= RESTING

    @property
    def is_best(self) -> bool:
        """Whether no equilibrium nearby is nearer by more than 1 %."""
        return self._within(LEAST * self.size_mm)

    @property
    def is_near(self) -> bool:
        """The same, or as near as the energy of the actuators in (T1) permits."""
        return self._within(LEAST * self.size_mm + CLOSE * self.offset_mm)

    def _within(self, least: float) -> bool:
        """Whether the error is that of the best place but for 1 % and a length [mm]."""
        return self.best_mm is None or self.error_mm <= (1.0 + NEAR) * self.best_mm + least


@dataclass(frozen=True, slots=True)
class StillBench:
    """Everything `python -m benchmarks still` measures.

    Attributes:
        machine: facts about it.
        settings: what was asked for.
        runs: to constant targets.
        orders: random orders.
        complete: whether all was done.
    """

    machine: HostInfo
    settings: StillSettings
    runs: tuple[StillRun, ...]
    orders: tuple[OrderRun, ...]
    complete: bool


def bench_still(settings: StillSettings, stop: StopFlag, progress: Progress) -> StillBench:
    """Measure all, or the runs that are done when `stop` is raised, which ends the one that is not.

    Args:
        settings: what.
        stop: raised to end early.
        progress: called with the share of the work that has just been done, and what comes next.

    Raises:
        RobotFileError, StateBasisError: a robot that cannot be loaded.
    """
    runs, orders = list[StillRun](), list[OrderRun]()
    share = 1.0 / (len(settings.robots) * len(settings.models))
    with one_blas_thread(), suppress(Interrupted):
        setups = [
            load_setup(name, model=model) for name in settings.robots for model in settings.models
        ]
        for setup in setups:
            what = f"{setup.robot.name}, {setup.order}"
            for run in _robot_runs(setup, settings, stop):
                runs.append(run)
                progress(0.8 * share / (3 * settings.targets), what)
            if settings.orders:
                orders.append(order_run(setup, settings.orders, settings.seed, stop))
            progress(0.2 * share, what)
    return StillBench(host_info(), settings, tuple(runs), tuple(orders), not stop.requested)


def _robot_runs(setup: Setup, settings: StillSettings, stop: StopFlag) -> Iterator[StillRun]:
    """The runs of one robot: without contact, in closed loop, and with contact where it has a basis."""
    rng = np.random.default_rng(settings.seed)
    cases: list[tuple[Loop, bool]] = [("open", False), ("closed", False)]
    if setup.contact != "none":
        cases.append(("open", True))
    share = 60.0 * settings.minutes / len(cases)  # s
    all_goals = tee(random_goals(setup.robot, rng, settings.targets), len(cases))
    for (loop, contact), goals in zip(cases, all_goals, strict=True):
        controller = Controller(
            setup.robot, setup.contact if contact else "none", settings=setup.controller
        )
        controller.settle_start()
        feedback = own_estimator(setup.robot, setup.service) if loop == "closed" else None
        end = monotonic() + share
        for goal in goals:
            yield still_run(setup, controller, goal, feedback, settings.seconds, stop)
            if monotonic() > end:
                break


def random_goals(robot: Robot, rng: np.random.Generator, count: int) -> Iterator[Array]:
    """Goal values (n_v,) within twice the workspace.

    Args:
        robot: where it gets to.
        rng: source of loads and factors.
        count: how many.
    """
    simulator, layout, found = Simulator(robot, "none"), robot.effector_layout, 0
    simulator.settle_start()
    start = simulator.effector_values
    while found < count:
        simulator.reset()
        chosen = rng.integers(0, 2, robot.n_a)
        chosen[rng.integers(robot.n_a)] = 1  # one at least
        load = _from_shares(robot, rng.uniform(0.0, 1.0, robot.n_a) * chosen)
        try:
            converged = simulator.settle(load.position, load.effort).converged
        except FactorisationError:
            continue
        if converged:
            change = layout.difference(simulator.effector_values, start)
            yield layout.moved(start, rng.uniform(0.2, 2.0) * change)
            found += 1


def _from_shares(robot: Robot, shares: Array) -> Command:
    """Positions, or efforts of actuators that keep these, at shares (n_a,) of the largest ones."""
    held, limits = robot.actuators.laws.held_by_force, robot.limits
    return Command.either(held, shares * limits.farthest_position, shares * limits.effort_max)


def still_run(
    setup: Setup, controller: Controller, goal: Array, feedback: Feedback | None, seconds: float,
    stop: StopFlag,
) -> StillRun:  # fmt: skip
    """Follow a constant target from the start.

    Args:
        setup: of the robot.
        controller: decides.
        goal: (n_v,) target.
        feedback: of a closed loop around a heavier robot; None: the loop is open.
        seconds: duration.
        stop: ends the run, with `Interrupted`.
    """
    controller.reset()
    robot, layout = controller.robot, controller.robot.effector_layout
    start, plant = controller.effector_values, None if feedback is None else _plant(robot)
    left, last = list[Actuation](), round(LAST / robot.h)
    more, correction = 0.0, np.zeros(layout.n_rows)  # s; (n_e,)
    if feedback is not None:
        feedback.reset()
        more = -np.log(STANDING * RESTING) / feedback.gain
    for tick in range(round((seconds + more) / robot.h)):
        stop.heed()
        left.append(controller.step(layout.moved(goal, correction)))
        if plant is not None and feedback is not None:
            _drive(plant, left[-1].position, left[-1].effort)
            measured = plant.simulator.effector_values
            correction = feedback.update(controller.effector_values, measured, robot.h)
        if tick % last == last - 1 and max(_changes(left[-last:], robot)) < STANDING * RESTING:
            break
    where = controller.effector_values if plant is None else plant.simulator.effector_values
    error = layout.error(where, goal)
    moved, pushed = _changes(left[-last:], robot)
    return StillRun(
        robot=robot.name,
        model=setup.order,
        loop="open" if feedback is None else "closed",
        contact=controller.space.k > 0 or controller.settings.enrichment.rounds > 0,
        offset_mm=1e3 * layout.error(goal, start),
        position=moved,
        effort=pushed,
        error_mm=1e3 * error,
        best_mm=1e3 * best_error(controller, goal, error, stop) if plant is None else None,
        statuses=tuple(sorted({one.status.name for one in left[-last:]})),
        rest_s=_time_to_rest(_shares(left, robot), robot),
        own_rest_s=own_time_to_rest(controller, len(left) + last, stop) if plant is None else None,
        size_mm=1e3 * robot.size,
    )


def _shares(left: list[Actuation], robot: Robot) -> Array:
    """Positions and efforts (ticks, 2, n_a), relative to their ranges."""
    return _of_ranges(np.array([(one.position, one.effort) for one in left]), robot)


def _of_ranges(left: Array, robot: Robot) -> Array:
    """Positions and efforts (ticks, 2, n_a), relative to their ranges."""
    limits = robot.limits
    position = limits.position_max - limits.position_min
    shares: Array = left / np.stack([position, limits.effort_max - limits.effort_min])
    return shares


def _changes(left: list[Actuation], robot: Robot) -> tuple[float, float]:
    """Largest change of a position and of an effort, relative to their ranges."""
    position, effort = np.ptp(_shares(left, robot), axis=0).max(axis=1).tolist()
    return position, effort


def _time_to_rest(shares: Array, robot: Robot) -> float | None:
    """Time from the last tick at a rate limit until all stays within `RESTING` [s]; None: it never does.

    Args:
        shares: (ticks, 2, n_a) positions and efforts, relative to their ranges.
        robot: its rates.
    """
    shares = shares.reshape(len(shares), -1)
    rate = robot.h * robot.limits.rate / (robot.limits.position_max - robot.limits.position_min)
    moved = np.abs(np.diff(shares[:, : robot.n_a], axis=0))
    at_rate = np.flatnonzero((moved > 0.99 * rate).any(axis=1))
    after = shares[::-1]  # (ticks, 2 n_a), the last first
    spread = np.maximum.accumulate(after) - np.minimum.accumulate(after)
    resting = np.flatnonzero((spread > RESTING).any(axis=1))
    rest = len(shares) - int(resting[0]) if len(resting) else 0  # first tick of what rests
    if rest >= len(shares) - 1:
        return None
    return robot.h * max(rest - (int(at_rate[-1]) + 1 if len(at_rate) else 0), 0)


def _plant(robot: Robot) -> DrivenRobot:
    """The robot under more gravity than its model has, settled."""
    none = np.zeros(3 * len(robot.effector_names))
    simulator = Simulator(robot.loaded(HEAVIER * robot.gravity, none), "none")
    simulator.settle_start()
    return DrivenRobot(simulator, steps=1)


def _drive(plant: DrivenRobot, position: Array, effort: Array) -> None:
    """A period under positions, or efforts of those that keep these: (n_a,)."""
    held = plant.simulator.robot.actuators.laws.held_by_force
    command = Command.either(held, position, effort)
    plant.move(command.position, command.effort)


def own_time_to_rest(controller: Controller, ticks: int, stop: StopFlag) -> float | None:
    """Time to rest where actuators go to where a controller has them as fast as they may, and stay [s].

    Args:
        controller: at rest.
        ticks: that this may take.
        stop: ends it, with `Interrupted`.
    """
    robot = controller.robot
    simulator = Simulator(robot, controller.space, controller.settings.enrichment)
    simulator.settle_start()
    body, way = DrivenRobot(simulator, steps=1), []
    for _ in range(ticks):
        stop.heed()
        _drive(body, controller.position, controller.effort)
        way.append((simulator.position, simulator.effort))
    return _time_to_rest(_of_ranges(np.array(way), robot), robot)


def best_error(controller: Controller, goal: Array, error: float, stop: StopFlag) -> float:
    """Least distance [m] from a goal that a descent over equilibria finds, from where a controller rests.

    The descent does not use any compliance: it settles a simulator at each point. Efforts beyond their limits
    and positions beyond theirs do not count.

    Args:
        controller: at rest.
        goal: (n_v,) target.
        error: of the controller there [m].
        stop: ends the descent, with `Interrupted`.
    """
    robot, limits = controller.robot, controller.robot.limits
    by_force = robot.actuators.laws.held_by_force
    least = np.where(by_force, limits.effort_min, limits.position_min)
    most = np.where(by_force, limits.effort_max, limits.position_max)
    start = np.where(by_force, controller.effort, controller.position)
    simulator = Simulator(robot, controller.space, controller.settings.enrichment)
    state, forces, best = controller.state, controller.forces, error
    layout, slack = robot.effector_layout, 1e-3 * limits.largest_effort

    def residual(shares: Array) -> Array:
        """Distances of the effector rows [m], and efforts beyond their limits times the error."""
        nonlocal best
        stop.heed()
        value = least + shares * (most - least)
        simulator.start_from(state, forces)
        command = Command.either(by_force, value, value)
        try:
            converged = simulator.settle(command.position, command.effort).converged
        except FactorisationError:
            converged = False
        if not converged:
            return np.full(layout.n_rows + robot.n_a, error)
        rows = layout.scale * layout.difference(simulator.effector_values, goal)
        lam, position = simulator.effort, simulator.position
        excess = np.maximum(lam - limits.effort_max, limits.effort_min - lam) - slack
        outside = np.maximum(limits.position_min - position, 0.0) * by_force
        if (excess <= 0.0).all() and not outside.any():
            best = min(best, layout.error(simulator.effector_values, goal))
        return np.concatenate(
            [rows, STIFF * error * np.maximum(excess / limits.largest_effort, 0.0)]
        )

    if error <= LEAST * robot.size:
        return best
    first = np.clip((start - least) / (most - least), 0.0, 1.0)
    least_squares(residual, first, bounds=(0.0, 1.0), diff_step=1e-4, max_nfev=DESCENT)
    return best
