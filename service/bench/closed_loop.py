"""`tauten bench closed-loop`: how far a robot is from a target that moves, and from its model.

A controller follows where the effector rests while the actuators go through their ranges, the path "reach",
once within a period. The commands that left then drive the controller's model once more, with steps of a
millisecond: from the model to it is the share of time, from it to the plant, which is of full order and has
pointwise contact, that of reduction. The error of the mesh is in neither: `tauten check` measures it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.controller import Controller
from tauten.model import Simulator, load_robot, one_blas_thread
from tauten.model.numerics import Array
from tauten.service.bench.following import Trace, follow, reach_targets, rms, warmed
from tauten.service.plant import DrivenRobot, PathError, own_steps
from tauten.service.process import HostInfo, Interrupted, Progress, StopFlag, host_info
from tauten.service.replay import Spread, spread
from tauten.service.settings import ServiceSettings
from tauten.service.setup import Setup

_REACH = 0.8  # of the range of each actuator
_FINE = 1e-3  # s, steps of the reduced model that the controller's is compared with


@dataclass(frozen=True, slots=True)
class DistanceSize:
    """Of a distance over a run: RMS and largest [mm]."""

    rms_mm: float
    max_mm: float


@dataclass(frozen=True, slots=True)
class Following:
    """A run along the path, first effector.

    Attributes:
        period_s: of the path.
        target: the plant from its target.
        own: the controller's model from it.
        apart: the plant from the model.
        time: the model from the same with fine steps, under what left.
        reduction: these from the plant.
        roughness: RMS of the second difference of efforts from tick to tick [N, Pa].
        step_ms: of the whole control step.
        unusable: decisions that could not be used.
    """

    period_s: float
    target: DistanceSize
    own: DistanceSize
    apart: DistanceSize
    time: DistanceSize
    reduction: DistanceSize
    roughness: float
    step_ms: Spread
    unusable: int


@dataclass(frozen=True, slots=True)
class ClosedLoopBench:
    """Everything `tauten bench closed-loop` measures.

    Attributes:
        machine: facts about it.
        robot: name.
        rate_hz: ticks a second.
        plant: order of the plant.
        plant_steps: its steps in a period.
        plant_error_percent: how far twice as many move it in a trial motion, of its way.
        plant_speed: its simulated time over real time there.
        plant_unknowns: degrees of freedom of the plant.
        model_unknowns: of the controller's model.
        mesh_error: of the mesh that both are made of, in a sentence.
        following: one a period.
        complete: whether all runs were done.
    """

    machine: HostInfo
    robot: str
    rate_hz: float
    plant: str
    plant_steps: int
    plant_error_percent: float
    plant_speed: float
    plant_unknowns: int
    model_unknowns: int
    mesh_error: str
    following: tuple[Following, ...]
    complete: bool


def bench_closed_loop(
    setup: Setup, periods: tuple[float, ...], stop: StopFlag, progress: Progress
) -> ClosedLoopBench:
    """Follow the path in reach once in each period, or in as many as are done when `stop` is raised.

    A request to stop ends the run that is under way.

    Args:
        setup: the robot.
        periods: of the path [s].
        stop: raised to end early.
        progress: called with the share of the work that has just been done, and what comes next.

    Raises:
        PathError: the robot has several effectors, or finds no equilibrium to take targets from.
        Interrupted: stopped before a run was done.
    """
    robot, followed = setup.robot, list[Following]()
    if len(robot.effector_names) > 1:
        raise PathError(
            f"{robot.name} has {len(robot.effector_names)} effectors, the path of this benchmark is for one"
        )
    with one_blas_thread():
        progress(0.0, "plant")
        with stop.interruptible():
            controller = Controller(robot, setup.contact, settings=setup.controller)
            controller.settle_start()
            simulator = Simulator(load_robot(setup.path, rate=1.0 / robot.h), "full")
            simulator.settle_start()
            steps = own_steps(simulator)
            plant = DrivenRobot(simulator, steps.count)
            warmed(controller, plant, setup.service)
        for period in periods:
            progress(0.0, f"path in reach, {period:g} s")
            try:
                with stop.interruptible():
                    found = follow_path(controller, plant, period, setup.service)
            except Interrupted:
                if not followed:
                    raise
                break
            followed.append(found)
            progress(period / sum(periods), f"path in reach, {period:g} s")
    return ClosedLoopBench(
        machine=host_info(),
        robot=robot.name,
        rate_hz=1.0 / robot.h,
        plant="full",
        plant_steps=steps.count,
        plant_error_percent=100.0 * steps.error,
        plant_speed=steps.speed,
        plant_unknowns=simulator.robot.n,
        model_unknowns=robot.n,
        mesh_error=setup.mesh_error,
        following=tuple(followed),
        complete=len(followed) == len(periods),
    )


def follow_path(
    controller: Controller, plant: DrivenRobot, period: float, settings: ServiceSettings
) -> Following:
    """Follow the path once, in open loop, and divide the distance of model and plant.

    Args:
        controller: at its start.
        plant: of full order.
        period: of the path [s].
        settings: of the loop.

    Raises:
        PathError: no equilibria.
    """
    trace = follow(controller, plant, reach_targets(controller.robot, period, _REACH), settings)
    fine = fine_tips(controller, plant, trace)
    return Following(
        period_s=period,
        target=size(trace.error),
        own=size(trace.own),
        apart=distance(trace.model, trace.effector),
        time=distance(trace.model, fine),
        reduction=distance(fine, trace.effector),
        roughness=rms(np.diff(trace.effort, n=2, axis=0)),
        step_ms=spread((1e3 * trace.step).tolist()),
        unusable=int(trace.unusable.sum()),
    )


def fine_tips(controller: Controller, plant: DrivenRobot, trace: Trace) -> Array:
    """First effector (s, 3) of the controller's model with fine steps under what left in a run [m].

    A model of the same order as the plant takes its steps.
    """
    robot = controller.robot
    steps = plant.steps
    if robot.n < plant.simulator.robot.n:
        steps = max(round(robot.h / _FINE), steps)
    simulator = Simulator(robot, controller.space, controller.settings.enrichment)
    simulator.settle_start()
    driven, found = DrivenRobot(simulator, steps), []
    for position, effort in zip(trace.position, trace.effort, strict=True):
        driven.follow(position, effort)
        found.append(simulator.effector[0])
    return np.array(found)


def size(metres: Array) -> DistanceSize:
    """RMS and largest of distances (s,) [m]."""
    return DistanceSize(1e3 * rms(metres), 1e3 * float(metres.max()))


def distance(one: Array, other: Array) -> DistanceSize:
    """Of positions (s, 3) from others [m]."""
    return size(np.linalg.norm(one - other, axis=1))
