"""The figure of a run: tip paths beside tension, pull, error and step time over time."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tauten.model import Actuators, Quantity
from tauten.model.numerics import Array
from tauten.service.replay import RecordedRun, Series, distance_to_goal

_TARGET, _MODEL, _PLANT, _LIMIT = "#222222", "#0072b2", "#d55e00", "#999999"
CABLE_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
_MM = 1e3
_LEAD = 0.5  # s shown before the first goal


@dataclass(frozen=True, slots=True)
class Shown:
    """How positions or efforts of actuators are shown on one axis.

    Attributes:
        names: of the actuators, with units where these differ.
        label: of the axis.
        unit: in brackets; "" where units differ.
        scale: (n_a,) from SI units to those shown.
    """

    names: tuple[str, ...]
    label: str
    unit: str
    scale: Array


def shown_positions(actuators: Actuators) -> Shown:
    """How the positions of actuators are shown."""
    return _shown(actuators.names, [kind.position for kind in actuators.kinds], "position")


def shown_efforts(actuators: Actuators) -> Shown:
    """How the efforts of actuators are shown."""
    return _shown(actuators.names, [kind.effort for kind in actuators.kinds], "effort")


def _shown(names: tuple[str, ...], quantities: list[Quantity], common: str) -> Shown:
    scale = np.array([quantity.scale for quantity in quantities])
    first = quantities[0]
    if all(quantity == first for quantity in quantities):
        return Shown(names, first.label, f"[{first.shown_unit}]", scale)
    pairs = zip(names, quantities, strict=True)
    return Shown(tuple(f"{name} [{item.shown_unit}]" for name, item in pairs), common, "", scale)


def draw_run(run: RecordedRun, actuators: Actuators, path: Path) -> None:
    """Draw a run.

    Args:
        run: the run.
        actuators: of the robot.
        path: of the figure; its suffix decides the format.
    """
    figure = Figure(figsize=(13.0, 8.0), layout="constrained")
    paths_box, time_box = figure.subfigures(1, 2, width_ratios=(1.0, 1.25), squeeze=False)[0]
    draw_paths(run, paths_box.subplots())
    axes = time_box.subplots(4, 1, sharex=True)
    draw_actuators(run.pull, shown_positions(actuators), axes[0])
    draw_actuators(run.tension, shown_efforts(actuators), axes[1])
    axes[0].legend(loc="upper right", ncols=4, fontsize="small")
    draw_error(run, axes[2])
    draw_step_time(run, axes[3])
    axes[-1].set_xlabel("time [s]")
    active = run.time[run.active]
    axes[-1].set_xlim(active[0] - _LEAD, max(float(run.time[-1]), active[0] + _LEAD))
    for axis in axes:
        axis.grid(alpha=0.3)
    time_box.align_ylabels(axes)
    figure.suptitle(f"{run.robot}: {len(run.ticks)} ticks at {run.rate:g} Hz")
    figure.savefig(path, dpi=150)


def draw_paths(run: RecordedRun, axes: Axes) -> None:
    """Target, model and plant tips in the plane in which they move most."""
    following = run.following
    goal = run.goal[following]
    model = run.model.value
    i, j = widest_plane(np.concatenate([goal, model])) if len(goal) + len(model) else (0, 2)
    lines = ((goal, "target", _TARGET, 3.5, 0.35), (run.plant.value, "plant", _PLANT, 1.8, 0.9))
    for points, name, color, width, alpha in (*lines, (model, "model", _MODEL, 1.2, 1.0)):
        if len(points):
            axes.plot(
                _MM * points[:, i], _MM * points[:, j],
                color=color, lw=width, alpha=alpha, label=name,
            )  # fmt: skip
    if len(model):
        axes.plot(_MM * model[0, i], _MM * model[0, j], "o", color=_MODEL, ms=6, label="start")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel(f"{'xyz'[i]} [mm]")
    axes.set_ylabel(f"{'xyz'[j]} [mm]")
    axes.set_title("tip paths")
    axes.grid(alpha=0.3)
    axes.legend(loc="best")


def widest_plane(points: Array) -> tuple[int, int]:
    """The two axes along which points (m, 3) spread most, in order."""
    extent = np.ptp(points, axis=0)
    first, second = sorted(np.argsort(extent, kind="stable")[-2:].tolist())
    return first, second


def draw_actuators(course: Series, shown: Shown, axes: Axes) -> None:
    """Draw commanded positions or efforts of all actuators.

    Args:
        course: their values over time.
        shown: names, units and label.
        axes: to draw into.
    """
    for index, name in enumerate(shown.names):
        color = CABLE_COLOURS[index % len(CABLE_COLOURS)]
        axes.plot(course.time, shown.scale[index] * course.value[:, index], color=color, label=name)
    axes.set_ylabel(shown.label)


def draw_error(run: RecordedRun, axes: Axes) -> None:
    """Distance of model and plant from the goal."""
    for series, name, color in ((run.plant, "plant", _PLANT), (run.model, "model", _MODEL)):
        if len(series.time):
            axes.plot(series.time, _MM * distance_to_goal(run, series), color=color, label=name)
    axes.set_ylabel("error [mm]")
    axes.set_ylim(bottom=0.0)
    axes.legend(loc="upper right", ncols=2, fontsize="small")


def draw_step_time(run: RecordedRun, axes: Axes) -> None:
    """Time of a control step and of the decision in it, below the deadline."""
    decided = [(t, tick) for t, tick in zip(run.time, run.ticks, strict=True) if tick.status]
    times = [t for t, _ in decided]
    axes.plot(
        times, [_MM * tick.step for _, tick in decided], ".", ms=2.5, color=_MODEL, label="step"
    )
    axes.plot(
        times, [_MM * tick.decide for _, tick in decided], ".", ms=2.5, color=_PLANT, label="decide"
    )
    axes.axhline(_MM / run.rate, color=_LIMIT, ls="--", label="period")
    axes.set_ylabel("step time [ms]")
    axes.set_ylim(bottom=0.0)
    axes.legend(loc="upper right", ncols=3, fontsize="small", markerscale=4)
