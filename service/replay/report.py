"""The numbers of a run: rate, times, deadlines, tracking errors, penetration."""

from __future__ import annotations

import itertools
import json
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from pydantic import TypeAdapter

from tauten.model import ActuatorKind, Quantity
from tauten.model.numerics import Array, Bools, rotation_between
from tauten.model.schema import EffectorKind
from tauten.reduction import write_text
from tauten.service.process import HostInfo, host_info
from tauten.service.replay.run import RecordedRun, Series
from tauten.service.wire import Mode, RunDescription, Tick

FOLLOWED = 0.99  # share of the ticks; a run that followed in fewer says so


@dataclass(frozen=True, slots=True)
class Spread:
    """Percentiles of something measured; None without a measurement."""

    p50: float | None
    p99: float | None
    max: float | None


@dataclass(frozen=True, slots=True)
class TrackingError:
    """Distance between goal and effector while following; None without a measurement.

    Of components with a weight in the objective; those that are left free have no goal.

    Attributes:
        rms_mm: of positions, distances and lengths.
        max_mm: of the same.
        rms_mrad: of the rotation of a frame.
        max_mrad: of the same.
        rms_ml: of a volume.
        max_ml: of the same.
    """

    rms_mm: float | None
    max_mm: float | None
    rms_mrad: float | None = None
    max_mrad: float | None = None
    rms_ml: float | None = None
    max_ml: float | None = None


@dataclass(frozen=True, slots=True)
class ActuatorPeak:
    """What was commanded of an actuator farthest from zero, in SI units.

    Attributes:
        name: of the actuator.
        kind: its kind, "cable", "chamber" and so on.
        position: pulled length, volume change, angle or travel.
        position_unit: m, m³ or rad.
        effort: tension, pressure, torque or force.
        effort_unit: N, Pa or N m.
    """

    name: str
    kind: str
    position: float
    position_unit: str
    effort: float
    effort_unit: str


@dataclass(frozen=True, slots=True)
class RunReport:
    """Numbers of a run, from the first to the last tick that followed a goal or could not.

    Attributes:
        robot: name.
        duration_s: seconds between these two ticks.
        ticks: number of ticks from the first to the last of them.
        following: ticks that followed a goal.
        hindered: ticks that did not, by cause.
        rate_hz: configured control rate.
        achieved_hz: measured rate of ticks.
        step_ms: decide, advance and prepare together.
        decide_ms: the decision alone.
        overhead_ms: work of a tick outside the control step.
        lateness_ms: how late ticks began.
        latency_ms: from the time in a target's header to its actuation.
        missed: number of missed deadlines.
        skipped: number of ticks that were skipped.
        model_error: distance of the model's effector from the goal of its tick.
        plant_error: distance of the plant's effector from the goal at that time.
        model_plant_error: distance between these two effectors.
        model_penetration_mm: deepest penetration that the model predicted.
        plant_penetration_mm: deepest in the plant; None without plant.
        peaks: largest position and effort of each actuator.
        modes: ticks by mode, of the whole run.
        statuses: decisions by status.
        clamped: ticks at which the actuation limiter changed the actuation.
        extra_columns: largest number of contacts that were added to the basis in a tick.
        health: last health of the node.
        complete: whether the log was finished.
        description: of the robot, as the node wrote it.
        machine: on which the report was made, with its load.
    """

    robot: str
    duration_s: float
    ticks: int
    following: int
    hindered: dict[str, int]
    rate_hz: float
    achieved_hz: float
    step_ms: Spread
    decide_ms: Spread
    overhead_ms: Spread
    lateness_ms: Spread
    latency_ms: Spread
    missed: int
    skipped: int
    model_error: TrackingError
    plant_error: TrackingError
    model_plant_error: TrackingError
    model_penetration_mm: float
    plant_penetration_mm: float | None
    peaks: list[ActuatorPeak]
    modes: dict[str, int]
    statuses: dict[str, int]
    clamped: int
    extra_columns: int
    health: dict[str, dict[str, str]]
    complete: bool
    description: RunDescription
    machine: HostInfo

    def save(self, path: Path) -> None:
        """Write as JSON."""
        write_text(path, json.dumps(self.as_dict(), indent=2) + "\n")

    def as_dict(self) -> dict[str, Any]:
        """The report in parts that JSON has."""
        found: dict[str, Any] = TypeAdapter(RunReport).dump_python(self, mode="json", by_alias=True)
        return found


def make_report(run: RecordedRun) -> RunReport:
    """Numbers of a run."""
    ticks, time = run.ticks[run.active], run.time[run.active]
    decided = [tick for tick in ticks if tick.status]
    duration = float(time[-1] - time[0])
    gap = finite(run.plant_gap.value)
    return RunReport(
        robot=run.description.name,
        duration_s=duration,
        ticks=len(ticks),
        following=int(run.following.sum()),
        hindered=dict(Counter(tick.cause.value for tick in ticks if tick.mode is not Mode.RUN)),
        rate_hz=run.description.rate,
        achieved_hz=(len(ticks) - 1) / duration if duration > 0.0 else 0.0,
        step_ms=spread([1e3 * tick.step for tick in decided]),
        decide_ms=spread([1e3 * tick.decide for tick in decided]),
        overhead_ms=spread(overheads(ticks, 1.0 / run.description.rate)),
        lateness_ms=spread([1e3 * tick.lateness for tick in ticks]),
        latency_ms=spread([1e3 * tick.latency for tick in ticks]),
        missed=sum(tick.slack < 0.0 for tick in ticks),
        skipped=sum(tick.skipped for tick in ticks),
        model_error=error(run.kind, *errors_to_goal(run, run.model)),
        plant_error=error(run.kind, *errors_to_goal(run, run.plant)),
        model_plant_error=error(run.kind, *model_against_plant(run)),
        model_penetration_mm=penetration(finite([tick.deepest_gap for tick in decided])),
        plant_penetration_mm=penetration(gap) if gap.size else None,
        peaks=actuator_peaks(run),
        modes=dict(Counter(tick.mode.value for tick in run.ticks)),
        statuses=dict(Counter(tick.status for tick in decided)),
        clamped=sum(tick.clamped for tick in ticks),
        extra_columns=max((tick.extra_columns for tick in ticks), default=0),
        health={name: {"message": h.message, **h.values} for name, h in run.health.items()},
        complete=run.complete,
        description=run.description,
        machine=host_info(),
    )


def actuator_peaks(run: RecordedRun) -> list[ActuatorPeak]:
    """Position and effort farthest from zero of each actuator."""
    position, effort = (_farthest(series.value) for series in (run.position, run.effort))
    return [
        ActuatorPeak(name, kind.value, position[i], kind.position.unit, effort[i], kind.effort.unit)
        for i, (name, kind) in enumerate(run.actuators)
    ]


def _farthest(values: Array) -> list[float]:
    """The value farthest from zero in each column of (m, n_a)."""
    rows = np.abs(values).argmax(axis=0)
    return [float(values[row, i]) for i, row in enumerate(rows.tolist())]


def overheads(ticks: tuple[Tick, ...], period: float) -> list[float]:
    """Work of each tick outside the control step [ms], from its lateness and the slack after it."""
    pairs = itertools.pairwise(ticks)
    return [1e3 * (period - tick.lateness - after.slack - tick.step) for tick, after in pairs]


def spread(values: list[float]) -> Spread:
    """Percentiles of the finite ones of some values."""
    found = finite(values)
    if found.size == 0:
        return Spread(None, None, None)
    return Spread(
        float(np.percentile(found, 50.0)), float(np.percentile(found, 99.0)), float(found.max())
    )


def error(kind: EffectorKind, distance: Array, angle: Array) -> TrackingError:
    """RMS and maximum of the finite ones of some errors.

    Args:
        kind: of the effector.
        distance: (m,) [m], of a volume [m³].
        angle: (m,) [rad], NaN where the effector is no frame.
    """
    found = _rms_and_max(1e3 * distance)
    if kind == "volume":
        ml = _rms_and_max(1e6 * distance)
        return TrackingError(None, None, rms_ml=ml[0], max_ml=ml[1])
    return TrackingError(*found, *_rms_and_max(1e3 * angle))


def _rms_and_max(errors: Array) -> tuple[float | None, float | None]:
    found = finite(errors)
    if found.size == 0:
        return None, None
    return float(np.sqrt(np.mean(found**2))), float(found.max())


def penetration(gaps: Array) -> float:
    """Deepest penetration of gaps [m] in millimetres."""
    return 1e3 * max(0.0, -float(gaps.min(initial=0.0)))  # without the sign of −0


def finite(values: ArrayLike) -> Array:
    """The finite ones of some values, flat."""
    every = np.asarray(values, dtype=float).ravel()
    found: Array = every[np.isfinite(every)]
    return found


def errors_to_goal(run: RecordedRun, series: Series) -> tuple[Array, Array]:
    """Distance (m,) [m, of volumes m³] and angle (m,) [rad] of a series from the goal at that time.

    NaN without a goal, and where no component has a weight; angles where the effector is no frame.
    """
    goal = np.where(run.following[:, None], run.goal, np.nan)
    return apart(series.value, held(run.time, goal, series.time), run.weighted)


def model_against_plant(run: RecordedRun) -> tuple[Array, Array]:
    """Distance and angle of the plant's effector from the model's while following, as `errors_to_goal`."""
    model = held(run.model.time, run.model.value, run.plant.time)
    distance, angle = apart(run.plant.value, model, run.weighted)
    following = followed(run, run.plant.time)
    return np.where(following, distance, np.nan), np.where(following, angle, np.nan)


def followed(run: RecordedRun, times: Array) -> Bools:
    """Whether a run followed a goal at some times (k,) [s]: (k,)."""
    found: Bools = held(run.time, run.following[:, None].astype(float), times)[:, 0] == 1.0
    return found


def apart(first: Array, second: Array, weighted: Bools) -> tuple[Array, Array]:
    """Distances (m,) and angles (m,) [rad] between goal values (m, v) of one effector.

    Args:
        first: goal values.
        second: other ones.
        weighted: (c,) components that count, x, y, z and rotations about the frame's own axes; NaN where none
            of a kind does.
    """
    lengths, turns = weighted[:3], weighted[3:]
    change = (first - second)[:, : len(lengths)]
    distance = np.linalg.norm(change[:, lengths], axis=1)
    if not lengths.any():
        distance = np.full(len(first), np.nan)
    if not turns.any():
        return distance, np.full(len(first), np.nan)
    pairs = zip(first[:, 3:], second[:, 3:], strict=True)
    turned = np.array([rotation_between(one, other) for one, other in pairs]).reshape(-1, 3)
    return distance, np.linalg.norm(turned[:, turns], axis=1)


def held(times: Array, values: Array, at: Array) -> Array:
    """Values (k, d) at some times, each constant until the next one; NaN before the first.

    Args:
        times: (m,) ascending [s].
        values: (m, d) at these times.
        at: (k,) times to evaluate at [s].
    """
    index = np.searchsorted(times, at, side="right") - 1
    if len(times) == 0:
        return np.full((len(at), values.shape[1]), np.nan)
    return np.where((index >= 0)[:, None], values[np.maximum(index, 0)], np.nan)


def table_rows(report: RunReport) -> list[tuple[str, str]]:
    """Names and values with units, for a terminal."""

    def ms(value: Spread) -> str:
        known = (value.p50, value.p99, value.max)
        return " / ".join("-" if one is None else f"{one:.2f}" for one in known) + " ms"

    def mm(value: TrackingError) -> str:
        pairs = [(value.rms_mm, value.max_mm, "mm"), (value.rms_mrad, value.max_mrad, "mrad")]
        pairs.append((value.rms_ml, value.max_ml, "ml"))
        known = [pair for pair in pairs if pair[0] is not None] or pairs[:1]
        texts = [f"{digits(a)} / {digits(b)} {unit}" for a, b, unit in known]
        return ", ".join(texts)

    counts = report.health.get("targets", {})
    return [
        ("ticks that followed / all", f"{report.following} / {report.ticks}{_hindrance(report)}"),
        ("rate, requested / achieved", f"{report.rate_hz:.1f} / {report.achieved_hz:.2f} Hz"),
        ("step p50 / p99 / max", ms(report.step_ms)),
        ("decide p50 / p99 / max", ms(report.decide_ms)),
        ("node overhead p50 / p99 / max", ms(report.overhead_ms)),
        ("target to actuation p50 / p99 / max", ms(report.latency_ms)),
        ("tick jitter p50 / p99 / max", ms(report.lateness_ms)),
        ("deadlines missed / ticks", f"{report.missed} / {report.ticks}"),
        (
            "targets accepted / refused",
            f"{counts.get('accepted', '-')} / {counts.get('refused', '-')}",
        ),
        ("tracking error of the model, RMS / max", mm(report.model_error)),
        ("tracking error of the plant, RMS / max", mm(report.plant_error)),
        ("plant against model, RMS / max", mm(report.model_plant_error)),
        ("deepest penetration, model", f"{digits(report.model_penetration_mm)} mm"),
        ("deepest penetration, plant", f"{digits(report.plant_penetration_mm)} mm"),
        *_peak_rows(report.peaks),
        ("mesh error", report.description.model.mesh_error),
        ("decisions", ", ".join(f"{k} {v}" for k, v in report.statuses.items()) or "none"),
    ]


def _peak_rows(peaks: list[ActuatorPeak]) -> list[tuple[str, str]]:
    """Largest positions, then largest efforts, a row for each quantity with its unit."""
    values: dict[Quantity, list[str]] = {}
    for peak in peaks:
        quantity = ActuatorKind(peak.kind).position
        values.setdefault(quantity, []).append(digits(quantity.scale * peak.position))
    for peak in peaks:
        quantity = ActuatorKind(peak.kind).effort
        values.setdefault(quantity, []).append(digits(quantity.scale * peak.effort))
    return [
        (f"largest {quantity.name}", f"{', '.join(texts)} {quantity.shown_unit}")
        for quantity, texts in values.items()
    ]


def not_followed(report: RunReport) -> str:
    """A sentence about a run that did not follow its targets all the time."""
    share = 1.0 - report.following / max(report.ticks, 1)
    decisions = ", ".join(f"{status} {count}" for status, count in report.statuses.items())
    return (
        f"the node held instead of following in {report.ticks - report.following} of {report.ticks} ticks "
        f"({100.0 * share:.0f} %){_hindrance(report)}; decisions: {decisions or 'none'}"
    )


def _hindrance(report: RunReport) -> str:
    """Why the other ticks did not follow, as the end of a row."""
    causes = ", ".join(f"{cause} {count}" for cause, count in report.hindered.items())
    return f"; held: {causes}" if causes else ""


def digits(value: float | None) -> str:
    """Three significant digits, and all of those before the point; "-" without a value."""
    if value is None:
        return "-"
    value = 0.0 if abs(value) < 1e-9 else value  # rounding, and the sign of a zero
    return f"{value:.0f}" if abs(value) >= 100.0 else f"{value:#.3g}".rstrip(".")
