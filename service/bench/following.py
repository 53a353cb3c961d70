"""A controller that follows targets against the full-order robot, which has time steps of its own.

Controller and plant run in this process in turns, in logical time: each tick is one period, however long its
work takes, so positions do not depend on the machine and only times do. The measurement of a tick is used in
the next.
"""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter, thread_time

import numpy as np

from tauten.controller import Controller
from tauten.model import Robot
from tauten.model.numerics import Array, Bools
from tauten.service.node import ControlLoop, Signals, own_estimator
from tauten.service.plant import Drive, DrivenRobot, PathSettings, make_path
from tauten.service.settings import ServiceSettings

_WARM_UP = 12  # ticks
_NEARBY = 0.01  # of the robot's size


@dataclass(frozen=True, slots=True)
class Trace:
    """A run, tick by tick.

    Attributes:
        effector: (s, 3) the plant's first effector [m].
        error: (s,) largest distance of the plant's effectors from their targets; of rotations and volumes
            in metres by the units of `EffectorLayout` [m].
        position: (s, n_a) commanded [m].
        effort: (s, n_a) commanded [N].
        decide: (s,) time from target to actuation [s].
        step: (s,) time of the whole control step [s].
        thread: (s,) time of the thread in it [s].
        touching: (s,) bool, the plant pushes against itself.
        unusable: (s,) bool, the decision could not be used.
        model: (s, 3) the controller's own first effector [m].
        own: (s,) distance of the controller's effectors from their targets, as `error` [m].
    """

    effector: Array
    error: Array
    position: Array
    effort: Array
    decide: Array
    step: Array
    thread: Array
    touching: Bools
    unusable: Bools
    model: Array
    own: Array


def follow(
    controller: Controller,
    plant: DrivenRobot,
    targets: Array,
    settings: ServiceSettings | None = None,
    closed: bool = False,
    drive: Drive = "pull",
) -> Trace:
    """Follow targets from the start of controller and plant, both already warm.

    Args:
        controller: decides.
        plant: moves.
        targets: (s, n_v) goal values, one row a period.
        settings: of the closed loop and of `ControlLoop`; default: as `ControlLoop`.
        closed: whether measurements correct the targets.
        drive: what the plant obeys, see `DrivenRobot.follow`.
    """
    controller.reset()
    plant.reset()
    robot, body = controller.robot, plant.simulator
    loop = ControlLoop(controller, settings=settings)
    loop.prepare()
    settings = settings or ServiceSettings()
    layout = robot.effector_layout
    feedback, correction = (
        own_estimator(robot, settings) if closed else None,
        np.zeros(layout.n_rows),
    )
    rows = []
    for target in targets:
        begin, busy = perf_counter(), thread_time()
        action = loop.tick(layout.moved(target, correction), Signals(target=True))
        decide, thread = perf_counter() - begin, thread_time() - busy
        sent = action.actuation
        plant.follow(sent.position, sent.effort, drive)
        begin, busy = perf_counter(), thread_time()
        loop.prepare()
        step, thread = decide + perf_counter() - begin, thread + thread_time() - busy
        where = body.effector_values  # (n_v,)
        usable = action.decided and sent.status.usable
        touching = bool((body.lam_c > 0.0).any())
        own = controller.effector[0], layout.error(controller.effector_values, target)
        measured = body.effector[0], layout.error(where, target), sent.position, sent.effort
        rows.append((*measured, decide, step, thread, touching, not usable, *own))
        if feedback is not None:
            correction = feedback.update(controller.effector_values, where, robot.h)
    return Trace(*(np.array(column) for column in zip(*rows, strict=True)))


def warmed(controller: Controller, plant: DrivenRobot, settings: ServiceSettings) -> Controller:
    """The controller after a few ticks towards a target nearby."""
    goal = controller.shifted(_NEARBY * controller.robot.size)
    follow(controller, plant, np.tile(goal, (_WARM_UP, 1)), settings)
    return controller


def reach_targets(robot: Robot, seconds: float, fraction: float) -> Array:
    """Goal values (s, n_v) along the path in reach of a robot with one effector, one row a tick.

    Args:
        robot: the robot.
        seconds: of the path, there and back.
        fraction: of the range of each actuator.
    """
    path = make_path("reach", robot, PathSettings(period=1.0, fraction=fraction))
    ticks = round(seconds / robot.h)
    return np.array([path.at(number / ticks) for number in range(1, ticks + 1)])


def rms(values: Array) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(np.square(values))))
