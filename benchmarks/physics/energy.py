"""`python -m benchmarks energy`: energy over time, cost of converged steps, distance of model and plant."""

from __future__ import annotations

from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from benchmarks.physics.loads import CableLoad
from benchmarks.physics.step_length import (
    StepLengthError,
    moved_by,
    settled_simulator,
    step_length_errors,
)
from tauten.controller import warm_controller
from tauten.model import Robot, Simulator, State, load_robot, one_blas_thread
from tauten.service.plant import PathSettings, make_path, own_steps
from tauten.service.process import HostInfo, Progress, host_info
from tauten.service.replay import Distances, Series, Spread, spread
from tauten.service.setup import load_setup

PULL, TENSION = 0.5, 0.4  # of the largest: one cable is pulled to a length, several get tensions
GRAVITY = 9.81  # m/s²
ASIDE = (
    0.6,
    0.8,
    0.0,
)  # direction of the force a held robot is released from, as large as its weight


@dataclass(frozen=True, slots=True)
class EnergySettings:
    """What is simulated.

    Attributes:
        robots: names or files.
        seconds: of each motion.
        path_seconds: of the demo's path; 0 leaves it out.
    """

    robots: tuple[str, ...] = ("finger", "manipulator")
    seconds: float = 10.0
    path_seconds: float = 10.0


@dataclass(frozen=True, slots=True)
class EnergyCourse:
    """Energy of a motion without damping.

    Attributes:
        robot: its name.
        motion: "free swing", released without gravity and cables, or "held" by its cables under gravity.
        steps: "single" or "converged".
        time: from the release on [s].
        energy: kinetic and potential, above the equilibrium's [J].
        largest_rise: in one step, relative to the energy at the start.
        left: at the end, relative to the energy at the start.
        speed: of the fastest node at the end [m/s, rad/s].
    """

    robot: str
    motion: str
    steps: str
    time: tuple[float, ...]
    energy: tuple[float, ...]
    largest_rise: float
    left: float
    speed: float


@dataclass(frozen=True, slots=True)
class StepCost:
    """Times of a plant's steps while a robot is moved to its load and back.

    Attributes:
        robot: its name.
        single_ms: with one linearisation.
        converged_ms: iterated to convergence.
        iterations: mean number of linearisations of a converged step.
        period_ms: of control.
    """

    robot: str
    single_ms: Spread
    converged_ms: Spread
    iterations: float
    period_ms: float


@dataclass(frozen=True, slots=True)
class PathDistance:
    """What plant and model would be apart on the demo's path, in logical time: no tick is late.

    Attributes:
        distances: their shares; the delay is one tick.
        step_lengths: errors of the length of a step under the same pulled lengths.
    """

    distances: Distances
    step_lengths: tuple[StepLengthError, ...]


@dataclass(frozen=True, slots=True)
class EnergyBench:
    """Everything `python -m benchmarks energy` measures."""

    machine: HostInfo
    courses: tuple[EnergyCourse, ...]
    costs: tuple[StepCost, ...]
    paths: tuple[PathDistance, ...]


def bench_energy(settings: EnergySettings, progress: Progress) -> EnergyBench:
    """Simulate everything.

    Args:
        settings: what.
        progress: called with the share of the work that is about to be done, and what it is.

    Raises:
        RobotFileError, MeshError: a robot that cannot be loaded.
    """
    courses: list[EnergyCourse] = []
    costs, paths = [], []
    share = 1.0 / (6 * len(settings.robots))
    with one_blas_thread():
        for name in settings.robots:
            robot = load_robot(name)
            for converged in (False, True):
                progress(share, f"{robot.name}, free swing")
                courses.append(free_swing(robot, settings.seconds, converged))
                progress(share, f"{robot.name}, held")
                courses.append(held(robot, settings.seconds, converged))
            progress(share, f"{robot.name}, times")
            costs.append(step_cost(robot))
            progress(share, f"{robot.name}, the demo's path")
            if settings.path_seconds > 0.0:
                paths.append(path_distance(name, settings.path_seconds))
    return EnergyBench(host_info(), tuple(courses), tuple(costs), tuple(paths))


def load_of(robot: Robot) -> CableLoad:
    """Pulled lengths (n_a,) [m] of a robot with one cable, tensions (n_a,) [N] on one of several."""
    if robot.n_a == 1:
        return CableLoad(position=PULL * robot.limits.position_max)
    return CableLoad(effort=TENSION * robot.limits.effort_max * (np.arange(robot.n_a) == 0))


def undamped(robot: Robot) -> Robot:
    """The robot without Rayleigh damping."""
    plain = replace(robot.integration, rayleigh_mass=0.0, rayleigh_stiffness=0.0)
    return robot.with_integration(plain)


def free_swing(robot: Robot, seconds: float, converged: bool) -> EnergyCourse:
    """Released from its load, without gravity, cables and contacts.

    Args:
        robot: the robot.
        seconds: of the motion.
        converged: whether steps are iterated.
    """
    light = undamped(robot).loaded(np.zeros(3), np.zeros(3 * len(robot.effector_names)))
    simulator = Simulator(light, contact="none")
    load_of(robot).settle(simulator)
    simulator.start_from(simulator.state)
    return course(
        "free swing", simulator, CableLoad(effort=np.zeros(robot.n_a)), seconds, converged
    )


def held(robot: Robot, seconds: float, converged: bool) -> EnergyCourse:
    """Held at the pulled lengths of its load, under gravity, with contact, released from a force aside.

    Args:
        robot: the robot.
        seconds: of the motion.
        converged: whether steps are iterated.
    """
    still = undamped(robot)
    simulator = Simulator(still)
    load_of(robot).settle(simulator)
    position, rest = simulator.position, simulator.state
    weight = GRAVITY * still.body.moving_mass
    aside = np.zeros(3 * len(robot.effector_names))
    aside[:3] = weight * np.array(ASIDE)
    simulator.load(robot.gravity, aside)
    simulator.settle(position=position)
    simulator.load(robot.gravity, np.zeros(3 * len(robot.effector_names)))
    return course("held", simulator, CableLoad(position=position), seconds, converged, rest)


def course(
    motion: str,
    simulator: Simulator,
    command: CableLoad,
    seconds: float,
    converged: bool,
    rest: State | None = None,
) -> EnergyCourse:
    """Energy of a simulation under a constant command.

    Args:
        motion: its name.
        simulator: where it starts.
        command: what its cables are held at.
        seconds: of the motion.
        converged: whether steps are iterated.
        rest: the equilibrium; None: at rest.
    """
    robot = simulator.robot
    least = 0.0 if rest is None else robot.energy(State(rest.q, 0.0 * rest.v))
    energies = [robot.energy(simulator.state) - least]
    for _ in range(round(seconds * robot.integration.rate)):
        command.step(simulator, converged)
        energies.append(robot.energy(simulator.state) - least)
    start = energies[0]
    return EnergyCourse(
        robot=robot.name,
        motion=motion,
        steps="converged" if converged else "single",
        time=tuple((np.arange(len(energies)) * robot.h).tolist()),
        energy=tuple(energies),
        largest_rise=float(np.diff(energies).max(initial=0.0) / start),
        left=energies[-1] / start,
        speed=float(np.abs(simulator.state.v).max()),
    )


def step_cost(robot: Robot, steps: int = 50) -> StepCost:
    """Times of steps of both kinds, one of each in turn.

    Args:
        robot: the robot, with contact.
        steps: from rest to the load and back.
    """
    plants, load = [Simulator(robot), Simulator(robot)], load_of(robot)
    times: tuple[list[float], list[float]] = ([], [])
    iterations = []
    for share in 0.5 - 0.5 * np.cos(np.linspace(0.0, 2.0 * np.pi, steps)):
        for plant, taken, converged in zip(plants, times, (False, True), strict=True):
            begin = perf_counter()
            report = load.scaled(share).step(plant, converged)
            taken.append(1e3 * (perf_counter() - begin))
        iterations.append(report.iterations)
    single, converged_ = (spread(taken[3:]) for taken in times)
    return StepCost(robot.name, single, converged_, float(np.mean(iterations)), 1e3 * robot.h)


def path_distance(name: str, seconds: float) -> PathDistance:
    """The controller on the demo's path, and simulations under its pulled lengths.

    Args:
        name: robot or file.
        seconds: of the path.
    """
    setup = load_setup(name, accept_error=True)
    controller, robot = warm_controller(setup), load_robot(name)
    path = make_path("reach", robot, PathSettings(period=10.0))
    time = robot.h * np.arange(1.0, round(seconds * robot.integration.rate) + 1)
    positions, model = [], []
    for moment in time % path.times[-1]:
        target = [np.interp(moment, path.times, path.values[:, axis]) for axis in range(3)]
        goal = np.vstack([target, controller.effector[1:]])
        actuation = controller.step(goal)
        positions.append(actuation.position)
        model.append(controller.effector[0])
    own = Simulator(robot, controller.space, controller.settings.enrichment)
    own.settle_start()  # as the controller
    plant = settled_simulator(robot)
    steps = 2 * own_steps(plant).count  # the model takes as many as the plant where one is enough
    as_model = moved_by(own, positions, max(controller.settings.substeps, 1))
    timed, full = moved_by(own, positions, steps), moved_by(plant, positions, steps)

    tips = np.array(model)
    late = np.vstack([full[:1], full[:-1]])
    pairs = {
        "state reduction": (tips, as_model),
        "time": (as_model, timed),
        "model without contact": (tips, timed),
        "contact basis": (timed, full),
        "delay": (late, full),
        "plant against model": (late, tips),
        "motion of the model in a tick": (tips, np.vstack([tips[:1], tips[:-1]])),
    }
    series = {
        name: Series(time, np.linalg.norm(one - other, axis=1).astype(float))
        for name, (one, other) in pairs.items()
    }
    found = Distances(robot.name, "own", series)
    return PathDistance(found, step_length_errors(setup, positions))
