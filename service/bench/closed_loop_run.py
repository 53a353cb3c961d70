"""One run of the closed-loop benchmark: a controller against the full-order robot, with steps of its own.

Node and plant run in this process in turns, in logical time: each tick is one period, however long its
work takes, so positions do not depend on the machine and only times do. The measurement of a tick is
used in the next.
"""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter
from typing import Literal

import numpy as np

from tauten.controller import Controller
from tauten.model.numerics import Array, Bools, FactorisationError
from tauten.service.bench.closed_loop_cases import Case
from tauten.service.node import LARGEST, ControlLoop, Feedback, Signals
from tauten.service.plant import DrivenRobot
from tauten.service.replay import Spread, spread
from tauten.service.settings import ServiceSettings

Drive = Literal["pull", "tension"]
_BAND = 0.02  # of a step, within which it counts as settled
_END = 0.1  # last part of a case, over which the remaining error is averaged


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
        touching: (s,) bool, the plant pushes against itself.
        unusable: decisions that could not be used.
        model: (s, 3) the controller's own first effector [m].
        own: (s,) distance of the controller's effectors from their targets, as `error` [m].
    """

    effector: Array
    error: Array
    position: Array
    effort: Array
    decide: Array
    step: Array
    touching: Bools
    unusable: int
    model: Array
    own: Array


@dataclass(frozen=True, slots=True)
class Outcome:
    """Numbers of a run.

    Attributes:
        case: name of the case.
        contact: model of contact in the controller.
        closed: whether measurements correct the targets.
        young_scale: the plant's Young's modulus over the model's.
        drive: what the plant's winches obey.
        ticks: length of the run.
        rms_mm: of the distance between target and plant.
        max_mm: largest.
        end_mm: mean over the last tenth.
        settling_s: time after a step from which on it remains within 2 % of the step; None without one.
        effort_n: RMS tension.
        chatter_mm_s: RMS change of a cable's speed from one tick to the next.
        latency_ms: from target to actuation.
        step_ms: of the whole control step.
        misses: control steps longer than the period.
        touching: share of the ticks at which the plant pushes against itself.
        unusable: decisions that could not be used.
    """

    case: str
    contact: str
    closed: bool
    young_scale: float
    drive: Drive
    ticks: int
    rms_mm: float
    max_mm: float
    end_mm: float
    settling_s: float | None
    effort_n: float
    chatter_mm_s: float
    latency_ms: Spread
    step_ms: Spread
    misses: int
    touching: float
    unusable: int


def follow(
    controller: Controller,
    plant: DrivenRobot,
    case: Case,
    closed: bool,
    drive: Drive,
    settings: ServiceSettings | None = None,
) -> Trace:
    """Follow a case's targets from the start of controller and plant, both already warm.

    Args:
        controller: decides.
        plant: moves.
        case: targets, one a period.
        closed: whether measurements correct the targets.
        drive: what the plant obeys: "tension", efforts; "pull", positions, and efforts of actuators that a
            hold keeps by these, as of pressure.
        settings: of the closed loop and of `ControlLoop`; default: as `ControlLoop`.
    """
    controller.reset()
    plant.reset()
    robot, body, loop = (
        controller.robot,
        plant.simulator,
        ControlLoop(controller, settings=settings),
    )
    loop.prepare()
    settings = settings or ServiceSettings()
    layout = robot.effector_layout
    feedback = Feedback(layout, settings.feedback_gain, LARGEST * robot.size)
    rows = []
    for target in case.targets:
        begin = perf_counter()
        action = loop.tick(layout.moved(target, feedback.correction), Signals(target=True))
        decide = perf_counter() - begin
        sent = action.actuation
        moved(plant, sent.position, sent.effort, drive)
        begin = perf_counter()
        loop.prepare()
        step = decide + perf_counter() - begin
        where = body.effector_values  # (n_v,)
        error = layout.error(where, target)
        usable = action.decided and sent.status.usable
        touching = bool((body.lam_c > 0.0).any())
        own = controller.effector[0], layout.error(controller.effector_values, target)
        measured = body.effector[0], error, sent.position, sent.effort
        rows.append((*measured, decide, step, touching, not usable, *own))
        if closed:
            feedback.update(controller.effector_values, where, robot.h)
    found = zip(*rows, strict=True)
    effector, errors, position, effort, decided, stepped, touched, unusable, model, own_errors = (
        found
    )
    return Trace(
        effector=np.array(effector),
        error=np.array(errors),
        position=np.array(position),
        effort=np.array(effort),
        decide=np.array(decided),
        step=np.array(stepped),
        touching=np.array(touched),
        unusable=sum(unusable),
        model=np.array(model),
        own=np.array(own_errors),
    )


def moved(plant: DrivenRobot, position: Array, effort: Array, drive: Drive) -> None:
    """Move a plant by what left, as `tauten plant` does; back to its start where it diverges.

    Args:
        plant: the plant.
        position: (n_a,) positions.
        effort: (n_a,) efforts.
        drive: which it obeys, see `follow`.
    """
    by_force = plant.simulator.robot.actuators.laws.held_by_force | (drive == "tension")
    try:
        plant.move(np.where(by_force, np.nan, position), np.where(by_force, effort, np.nan))
    except FactorisationError:
        plant.reset()


def case_outcome(
    case: Case, trace: Trace, h: float, contact: str, closed: bool, young_scale: float, drive: Drive
) -> Outcome:
    """Numbers of a run.

    Args:
        case: its targets.
        trace: the run, tick by tick.
        h: control period [s].
        contact: model of contact in the controller.
        closed: whether measurements corrected the targets.
        young_scale: the plant's Young's modulus over the model's.
        drive: what the plant's winches obeyed.
    """
    speed = np.diff(trace.position, axis=0) / h  # (s - 1, n_a) m/s
    end = max(int(_END * len(trace.error)), 1)
    return Outcome(
        case=case.name,
        contact=contact,
        closed=closed,
        young_scale=young_scale,
        drive=drive,
        ticks=len(trace.error),
        rms_mm=1e3 * rms(trace.error),
        max_mm=1e3 * float(trace.error.max()),
        end_mm=1e3 * float(trace.error[-end:].mean()),
        settling_s=settling(case, trace, h),
        effort_n=rms(trace.effort),
        chatter_mm_s=1e3 * rms(np.diff(speed, axis=0)),
        latency_ms=spread((1e3 * trace.decide).tolist()),
        step_ms=spread((1e3 * trace.step).tolist()),
        misses=int((trace.step > h).sum()),
        touching=float(trace.touching.mean()),
        unusable=trace.unusable,
    )


def rms(values: Array) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def settling(case: Case, trace: Trace, h: float) -> float | None:
    """Seconds from a step after which the error remains within 2 % of it; None: it does not, or no step.

    Args:
        case: its targets.
        trace: the run, tick by tick.
        h: control period [s].
    """
    if case.from_tick == 0:
        return None
    outside = np.flatnonzero(trace.error > _BAND * case.jump)
    settled = int(outside[-1]) + 1 if len(outside) else case.from_tick
    return None if settled >= len(trace.error) else h * (settled - case.from_tick)
