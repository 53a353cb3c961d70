"""`tauten bench steps`: times of forward and inverse steps on a mesh and its refinements."""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter
from typing import Literal

import numpy as np

from tauten.controller import Controller
from tauten.model import ContactSpace, Robot, Simulator, load_robot, one_blas_thread
from tauten.model.numerics import Array
from tauten.service.process import HostInfo, Progress, host_info
from tauten.service.replay import Spread, spread

WARM_UP = 5  # steps that are not measured


@dataclass(frozen=True, slots=True)
class Sizes:
    """Sizes of a robot's problems."""

    nodes: int
    elements: int
    unknowns: int
    cables: int
    candidates: int
    modes: int


@dataclass(frozen=True, slots=True)
class SizeTimes:
    """Steps of one mesh without contact.

    Attributes:
        sizes: of its problems.
        factorisation: back end.
        forward_ms: a simulator's step under a pulled length.
        inverse_ms: a controller's step, target to advanced model.
    """

    sizes: Sizes
    factorisation: str
    forward_ms: Spread
    inverse_ms: Spread


@dataclass(frozen=True, slots=True)
class StepBench:
    """Everything `tauten bench steps` measures."""

    machine: HostInfo
    robot: str
    meshes: tuple[SizeTimes, ...]


def sizes_of(robot: Robot, modes: int = 0) -> Sizes:
    """Sizes of a robot's problems."""
    return Sizes(robot.n_nodes, robot.body.n_elements, robot.n, robot.n_a, robot.n_c, modes)


def bench_steps(
    robot_file: str, refinements: int, factorisation: str, steps: int, progress: Progress
) -> StepBench:
    """Time forward and inverse steps without contact on a mesh and its uniform refinements.

    The pull grows from zero to half its limit.
    """
    meshes = []
    for count in range(refinements + 1):
        robot = load_robot(robot_file, None, count, factorisation)
        with one_blas_thread():
            forward, reached = forward_steps(robot, steps)
            inverse = time_control(robot, "none", reached, WARM_UP)
        meshes.append(SizeTimes(sizes_of(robot), robot.body.linear_solver, forward, inverse))
        progress(1.0 / (refinements + 1))
    return StepBench(host_info(), robot.name, tuple(meshes))


def forward_steps(robot: Robot, steps: int) -> tuple[Spread, Array]:
    """Times of simulator steps [ms] while the cables are pulled to half their limit, and where they lead.

    These are values (steps + WARM_UP, n_v) of the effectors.
    """
    simulator, times, values = Simulator(robot, contact="none"), [], []
    for share in np.linspace(0.0, 0.5, steps + WARM_UP):
        start = perf_counter()
        simulator.step(position=share * robot.limits.position_max)
        times.append(1e3 * (perf_counter() - start))
        values.append(simulator.effector_values)
    return spread(times[WARM_UP:]), np.array(values)


def time_control(
    robot: Robot,
    contact: Literal["none", "full"] | ContactSpace,
    targets: Array,
    warm_up: int = 20,
) -> Spread:
    """Times of control steps that follow targets, prepare, decide and advance [ms].

    Args:
        robot: what to control.
        contact: "none", "full" or a basis.
        targets: (s, n_v) goal values, one row a step.
        warm_up: first steps, which are not measured.
    """
    controller, times = Controller(robot, contact), []
    for target in targets:
        start = perf_counter()
        controller.step(target)
        times.append(1e3 * (perf_counter() - start))
    return spread(times[warm_up:])
