"""Numbers of one run of a case."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.control.targets import Case
from tauten.service.bench import Trace, rms
from tauten.service.plant import Drive
from tauten.service.replay import Spread, spread

_BAND = 0.02  # of a step, within which it counts as settled
_END = 0.1  # last part of a case, over which the remaining error is averaged


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
        unusable=int(trace.unusable.sum()),
    )


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
