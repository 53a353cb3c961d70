"""How far a robot is from a target that moves, and what the distance of model and plant consists of.

A controller follows where the effector rests while the actuators go through their ranges, the path "reach",
once within a period. The commands that left then drive the controller's model once more, with steps of a
millisecond: from the model to it is the share of time, from it to the plant, which is of full order and has
pointwise contact, that of reduction. The error of the mesh is in neither: `tauten check` measures it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.controller import Controller
from tauten.model import Robot, Simulator
from tauten.model.numerics import Array
from tauten.service.bench.closed_loop_cases import Case
from tauten.service.bench.closed_loop_run import Trace, follow, moved, rms
from tauten.service.plant import DrivenRobot, PathError, PathSettings, make_path
from tauten.service.replay import Spread, spread
from tauten.service.settings import ServiceSettings

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


def path_case(robot: Robot, seconds: float) -> Case:
    """Targets along the path, one a tick.

    Args:
        robot: with one effector.
        seconds: of the path.

    Raises:
        PathError: there are several effectors, or no equilibria.
    """
    if len(robot.effector_names) > 1:
        raise PathError(
            f"{robot.name} has {len(robot.effector_names)} effectors, the path of this benchmark is for one"
        )
    settings = PathSettings(fraction=_REACH, period=1.0)
    path, ticks = make_path("reach", robot, settings), round(seconds / robot.h)
    targets = np.array([path.at(number / ticks) for number in range(1, ticks + 1)])
    return Case("reach", targets, 0)


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
        PathError: as of `path_case`.
    """
    case = path_case(controller.robot, period)
    trace = follow(controller, plant, case, False, "pull", settings)
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
        unusable=trace.unusable,
    )


def fine_tips(controller: Controller, plant: DrivenRobot, trace: Trace) -> Array:
    """First effector (s, 3) of the controller's model with fine steps under what left [m].

    Args:
        controller: its robot and contact basis.
        plant: of full order; a model of the same order takes its steps.
        trace: the run.
    """
    robot = controller.robot
    steps = plant.steps
    if robot.n < plant.simulator.robot.n:
        steps = max(round(robot.h / _FINE), steps)
    simulator = Simulator(robot, controller.space, controller.settings.enrichment)
    simulator.settle_start()
    driven, found = DrivenRobot(simulator, steps), []
    for position, effort in zip(trace.position, trace.effort, strict=True):
        moved(driven, position, effort, "pull")
        found.append(simulator.effector[0])
    return np.array(found)


def size(metres: Array) -> DistanceSize:
    """RMS and largest of distances (s,) [m]."""
    return DistanceSize(1e3 * rms(metres), 1e3 * float(metres.max()))


def distance(one: Array, other: Array) -> DistanceSize:
    """Of positions (s, 3) from others [m]."""
    return size(np.linalg.norm(one - other, axis=1))
