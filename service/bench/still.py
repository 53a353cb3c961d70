"""`tauten bench still`: whether robots come to rest at constant targets, where, and whether they get stuck.

Random targets within twice the workspace: effectors at random equilibria, and up to twice as far away.
In closed loop the robot is the same model under a tenth more gravity, which the controller does not know.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.optimize import minimize

from tauten.controller import Actuation, Controller
from tauten.model import Robot, Simulator
from tauten.model.numerics import Array, FactorisationError
from tauten.service.node import LARGEST, Feedback
from tauten.service.process import HostInfo, StopFlag, host_info, one_blas_thread
from tauten.service.setup import Order, Setup, load_setup

Progress = Callable[[float, str], None]
Loop = Literal["open", "closed"]

SHIPPED = (
    "finger", "trunk", "diamond", "pneumatic_finger", "gripper", "tripod", "accordion", "manipulator",
)  # fmt: skip
RESTING = 1e-6  # of the range of a position or an effort
NEAR = 0.01  # of the best error, and
CLOSE = 1e-3  # of the way to the target, within which an error is as good as the best
LAST = 0.2  # part of a run that is to be at rest
HEAVIER = 1.1  # gravity of the robot in closed loop
AFTER = 1.0  # s, from the last unlock and the time that slack takes until decisions go on


@dataclass(frozen=True, slots=True)
class StillSettings:
    """What is measured.

    Attributes:
        robots: names or files.
        models: "full" and "reduced".
        targets: of each robot, model, loop and contact.
        orders: random locks, holds, unlocks and targets of each robot; 0: none.
        seconds: of each run.
        seed: of targets and orders.
    """

    robots: tuple[str, ...] = SHIPPED
    models: tuple[Order, ...] = ("reduced",)
    targets: int = 10
    orders: int = 400
    seconds: float = 8.0
    seed: int = 0


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

    @property
    def rests(self) -> bool:
        """Whether it is at rest."""
        return self.position <= RESTING and self.effort <= RESTING

    @property
    def is_best(self) -> bool:
        """Whether no equilibrium nearby is nearer by more than 1 %."""
        if self.best_mm is None:
            return True
        return self.error_mm <= (1.0 + NEAR) * self.best_mm + CLOSE * self.offset_mm


@dataclass(frozen=True, slots=True)
class OrderRun:
    """Random orders.

    Attributes:
        robot: name.
        orders: how many.
        unusable: decisions among them that could not be used.
        stuck: unusable decisions after the last unlock and the time to wind in what is slack.
        beyond: largest share by which what left exceeded a limit.
        needed: largest share by which the model's efforts exceed a limit at the end.
    """

    robot: str
    orders: int
    unusable: int
    stuck: int
    beyond: float
    needed: float


@dataclass(frozen=True, slots=True)
class StillBench:
    """Everything `tauten bench still` measures.

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
    """Measure all, or as much as is done when `stop` is raised.

    Args:
        settings: what.
        stop: raised to end early.
        progress: called with the share of the work that has just been done, and what comes next.

    Raises:
        RobotFileError, StateBasisError: a robot that cannot be loaded.
    """
    runs, orders = list[StillRun](), list[OrderRun]()
    share = 1.0 / (len(settings.robots) * len(settings.models))
    with one_blas_thread():
        for name in settings.robots:
            for model in settings.models:
                if stop.requested:
                    break
                setup = load_setup(name, model=model)
                for run in _robot_runs(setup, settings, stop):
                    runs.append(run)
                    progress(0.8 * share / (3 * settings.targets), f"{name}, {model}")
                if settings.orders and not stop.requested:
                    orders.append(_order_run(setup, settings))
                progress(0.2 * share, f"{name}, {model}")
    return StillBench(host_info(), settings, tuple(runs), tuple(orders), not stop.requested)


def _robot_runs(setup: Setup, settings: StillSettings, stop: StopFlag) -> Iterator[StillRun]:
    """The runs of one robot: without contact, in closed loop, and with contact where it has a basis."""
    rng = np.random.default_rng(settings.seed)
    cases: list[tuple[Loop, bool]] = [("open", False), ("closed", False)]
    if setup.contact != "none":
        cases.append(("open", True))
    goals = list(random_goals(setup.robot, rng, settings.targets))
    for loop, contact in cases:
        controller = Controller(
            setup.robot, setup.contact if contact else "none", settings=setup.controller
        )
        controller.settle_start()
        for goal in goals:
            if stop.requested:
                return
            yield still_run(setup, controller, goal, loop, settings.seconds)


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
        load = _from_shares(robot, rng.uniform(0.0, 1.0, robot.n_a) * rng.integers(0, 2, robot.n_a))
        try:
            converged = simulator.settle(*load).converged
        except FactorisationError:
            continue
        if converged:
            change = layout.difference(simulator.effector_values, start)
            yield layout.moved(start, rng.uniform(0.2, 2.0) * change)
            found += 1


def _from_shares(robot: Robot, shares: Array) -> tuple[Array, Array]:
    """Positions and efforts (n_a,), NaN where the other is given, at shares of the largest ones."""
    held, limits = robot.actuators.laws.held_by_force, robot.limits
    pull = np.where(held, np.nan, shares * limits.farthest_pull)
    return pull, np.where(held, shares * limits.tension_max, np.nan)


def still_run(
    setup: Setup, controller: Controller, goal: Array, loop: Loop, seconds: float
) -> StillRun:
    """Follow a constant target from the start.

    Args:
        setup: of the robot.
        controller: decides.
        goal: (n_v,) target.
        loop: open, or closed around a heavier robot.
        seconds: duration.
    """
    controller.reset()
    robot, layout = controller.robot, controller.robot.effector_layout
    start, plant = controller.effector_values, _plant(robot) if loop == "closed" else None
    feedback = Feedback(layout, setup.service.feedback_gain, LARGEST * robot.size)
    left = list[Actuation]()
    held = robot.actuators.laws.held_by_force
    for _ in range(round(seconds / robot.h)):
        left.append(controller.step(layout.moved(goal, feedback.correction)))
        if plant is not None:
            pull = np.where(held, np.nan, left[-1].pull)
            plant.step(pull, np.where(held, left[-1].tension, np.nan))
            feedback.observe(controller.effector_values, plant.effector_values, robot.h)
    last, limits = left[-max(round(LAST * len(left)), 2) :], robot.limits
    where = controller.effector_values if plant is None else plant.effector_values
    error = layout.error(where, goal)
    return StillRun(
        robot=robot.name,
        model=setup.order,
        loop=loop,
        contact=controller.space.k > 0 or controller.settings.enrichment.rounds > 0,
        offset_mm=1e3 * layout.error(goal, start),
        position=_change([one.pull for one in last], limits.pull_max - limits.pull_min),
        effort=_change([one.tension for one in last], limits.tension_max - limits.tension_min),
        error_mm=1e3 * error,
        best_mm=1e3 * best_error(controller, goal, error) if plant is None else None,
        statuses=tuple(sorted({one.status.name for one in last})),
    )


def _change(values: list[Array], range_: Array) -> float:
    """Largest change among values (n_a,), relative to a range (n_a,)."""
    return float((np.ptp(np.array(values), axis=0) / range_).max())


def _plant(robot: Robot) -> Simulator:
    """The robot under more gravity than its model has, settled."""
    none = np.zeros(3 * len(robot.effector_names))
    plant = Simulator(robot.loaded(HEAVIER * robot.gravity, none), "none")
    plant.settle_start()
    return plant


def best_error(controller: Controller, goal: Array, error: float) -> float:
    """Least distance [m] from a goal that a descent over equilibria finds, from where a controller rests.

    The descent does not use any compliance: it settles a simulator at each point. Efforts beyond their limits
    and positions beyond theirs do not count.

    Args:
        controller: at rest.
        goal: (n_v,) target.
        error: of the controller there [m].
    """
    robot, limits = controller.robot, controller.robot.limits
    by_force = robot.actuators.laws.held_by_force
    least = np.where(by_force, limits.tension_min, limits.pull_min)
    most = np.where(by_force, limits.tension_max, limits.pull_max)
    start = np.where(by_force, controller.tension, controller.pull)
    simulator = Simulator(robot, controller.space, controller.settings.enrichment)
    state, forces, best = controller.state, controller.forces, error
    layout, slack = robot.effector_layout, 1e-3 * limits.largest_tension

    def squared(shares: Array) -> float:
        nonlocal best
        value = least + np.clip(shares, 0.0, 1.0) * (most - least)
        simulator.start_from(state, forces)
        command = np.where(by_force, np.nan, value), np.where(by_force, value, np.nan)
        try:
            if not simulator.settle(*command).converged:
                return error**2
        except FactorisationError:
            return error**2
        rows = layout.scale * layout.difference(simulator.effector_values, goal)
        found = layout.error(simulator.effector_values, goal)
        lam, pull = simulator.tension, simulator.pull
        excess = np.maximum(lam - limits.tension_max, limits.tension_min - lam) - slack
        outside = np.maximum(limits.pull_min - pull, 0.0) * by_force
        if (excess <= 0.0).all() and not outside.any():
            best = min(best, found)
        penalty = np.maximum(excess / limits.largest_tension, 0.0)
        return float(rows @ rows) + error**2 * float(penalty @ penalty + penalty.sum())

    first = (start - least) / (most - least)
    minimize(
        squared, first, method="L-BFGS-B", bounds=[(0.0, 1.0)] * len(first),
        options={"maxiter": 8, "eps": 1e-4},
    )  # fmt: skip
    return best


def _order_run(setup: Setup, settings: StillSettings) -> OrderRun:
    """Random orders, then targets at the start until decisions go on.

    Args:
        setup: of the robot.
        settings: number of orders, seed.
    """
    rng, robot = np.random.default_rng(settings.seed), setup.robot
    controller = Controller(robot, setup.contact, settings=setup.controller)
    controller.settle_start()
    start, layout, limits = controller.effector_values, robot.effector_layout, robot.limits
    unusable, stuck, beyond = 0, 0, 0.0
    names, goal = robot.actuators.names, start
    for _ in range(settings.orders):
        i, choice = int(rng.integers(len(names))), int(rng.integers(5))
        if choice == 0:
            controller.lock(names[i], position=_within(rng, limits.pull_min, limits.pull_max, i))
        elif choice == 1:
            controller.lock(names[i], force=_within(rng, limits.tension_min, limits.tension_max, i))
        elif choice == 2:
            _unlock(controller, i)
        elif choice == 3:
            change = rng.normal(size=layout.n_rows) * 0.1 * robot.size / layout.units
            goal = layout.moved(start, change)
        for _ in range(int(rng.integers(1, 5))):
            actuation = controller.hold() if choice == 4 else controller.decide(goal)
            controller.advance()
            unusable += choice != 4 and not actuation.status.usable
            beyond = max(beyond, _excess(robot, actuation.tension, actuation.pull))
    for i in range(len(names)):
        _unlock(controller, i)
    slack = (limits.pull_max - limits.pull_min) / limits.rate  # (n_a,) s, at most
    wait = round((float(slack.max()) + AFTER) / robot.h)
    for tick in range(wait + round(AFTER / robot.h)):
        actuation = controller.step(start)
        stuck += tick >= wait and not actuation.status.usable
        beyond = max(beyond, _excess(robot, actuation.tension, actuation.pull))
    needed = _excess(robot, actuation.needed, actuation.pull)
    return OrderRun(robot.name, settings.orders, unusable, stuck, beyond, needed)


def _within(rng: np.random.Generator, least: Array, most: Array, i: int) -> float:
    """A random value between limits (n_a,) of actuator i."""
    return float(rng.uniform(least[i], most[i]))


def _unlock(controller: Controller, i: int) -> None:
    """Decide actuator i again, where it is locked."""
    locks = controller.locks
    if locks.by_position[i] or locks.by_force[i]:
        controller.unlock(controller.robot.actuators.names[i])


def _excess(robot: Robot, effort: Array, pull: Array) -> float:
    """Largest share by which efforts and positions (n_a,) are beyond their limits."""
    limits = robot.limits
    above = np.maximum(effort - limits.tension_max, limits.tension_min - effort)
    outside = np.maximum(pull - limits.pull_max, limits.pull_min - pull)
    share = np.maximum(
        above / limits.largest_tension, outside / (limits.pull_max - limits.pull_min)
    )
    return max(float(share.max()), 0.0)
