"""Figures of runs: paths, actuation, errors and step times; a replay; shares of a distance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tauten.model import Actuators, Quantity
from tauten.model.numerics import Array, Bools, Ints
from tauten.service.plots.saving import save_figure
from tauten.service.replay import Distances, RecordedRun, Replay, Series, apart, errors_to_goal

_TARGET, _MODEL, _PLANT, _LIMIT = "#222222", "#0072b2", "#d55e00", "#999999"
CABLE_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
_MM = 1e3
_REST = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])  # a frame at rest, apart from its position
# of lines over each other: name, colour, width and opacity
_LINES = (
    ("target", _TARGET, 3.5, 0.35), ("plant", _PLANT, 1.8, 0.9), ("model", _MODEL, 1.2, 1.0),
)  # fmt: skip
_LEAD = 0.5  # s shown before the first tick that follows


@dataclass(frozen=True, slots=True)
class Shown:
    """Actuators whose positions or efforts are one quantity: they share an axis.

    Attributes:
        quantity: what is shown.
        names: of the actuators.
        columns: (k,) their places among all actuators.
    """

    quantity: Quantity
    names: tuple[str, ...]
    columns: Ints


def shown_quantities(actuators: Actuators) -> tuple[tuple[Shown, ...], tuple[Shown, ...]]:
    """How the positions and the efforts of actuators are shown: one item for each quantity."""
    names, kinds = actuators.names, actuators.kinds
    positions, efforts = [kind.position for kind in kinds], [kind.effort for kind in kinds]
    return _shown(names, positions), _shown(names, efforts)


def _shown(names: tuple[str, ...], quantities: list[Quantity]) -> tuple[Shown, ...]:
    found = []
    for quantity in dict.fromkeys(quantities):
        columns = [place for place, other in enumerate(quantities) if other == quantity]
        found.append(Shown(quantity, tuple(names[c] for c in columns), np.array(columns)))
    return tuple(found)


def draw_run(run: RecordedRun, actuators: Actuators, path: Path) -> None:
    """Draw a run."""
    positions, efforts = shown_quantities(actuators)
    commanded = len(positions) + len(efforts)
    figure = Figure(figsize=(13.0, max(8.0, 1.6 * (commanded + 2))), layout="constrained")
    paths_box, time_box = figure.subfigures(1, 2, width_ratios=(1.0, 1.25), squeeze=False)[0]
    lengths, turns = run.weighted[:3], run.weighted[3:]
    if lengths.sum() >= 2:
        draw_paths(run, paths_box.subplots())
    elif lengths.any():
        draw_values(run, paths_box.subplots())
    else:
        draw_turns(run, paths_box.subplots())
    axes = time_box.subplots(commanded + 1 + lengths.any() + turns.any(), 1, sharex=True)
    for course, groups, panels in (
        (run.position, positions, axes[: len(positions)]),
        (run.effort, efforts, axes[len(positions) : commanded]),
    ):
        for shown, panel in zip(groups, panels, strict=True):
            draw_actuators(course, shown, panel)
    for panel in axes[: len(positions)]:
        draw_legend(panel)
    if lengths.any():
        unit = ("ml", 1e6) if run.kind == "volume" else ("mm", _MM)
        draw_error(run, axes[commanded], 0, *unit)
        draw_legend(axes[commanded])
    if turns.any():
        draw_error(run, axes[-2], 1, "mrad", 1e3)
    draw_step_time(run, axes[-1])
    axes[-1].set_xlabel("time [s]")
    followed = run.time[run.following if run.following.any() else run.active]
    axes[-1].set_xlim(followed[0] - _LEAD, max(float(run.time[-1]), followed[0] + _LEAD))
    for axis in axes:
        axis.grid(alpha=0.3)
    time_box.align_ylabels(axes)
    figure.suptitle(
        f"{run.description.name}: {len(run.ticks)} ticks at {run.description.rate:g} Hz"
    )
    save_figure(figure, path, dpi=150)


def draw_paths(run: RecordedRun, axes: Axes) -> None:
    """Target, model and plant tips in the plane in which they move most, of components with a weight."""
    following = run.following
    goal = run.goal[following, :3]
    model = run.model.value[:, :3]
    i, j = widest_plane(np.concatenate([goal, model]), run.weighted[:3])
    shown = (goal, run.plant.value, model)
    for points, (name, color, width, alpha) in zip(shown, _LINES, strict=True):
        if len(points):
            axes.plot(
                _MM * points[:, i], _MM * points[:, j],
                color=color, lw=width, alpha=alpha, label=name,
            )  # fmt: skip
    if len(model):
        axes.plot(_MM * model[0, i], _MM * model[0, j], "o", color=_MODEL, ms=6, label="start")
    axes.set_aspect("equal", adjustable="datalim")
    axes.locator_params(axis="x", nbins=5)  # labels of small movements are long
    axes.set_xlabel(f"{'xyz'[i]} [mm]")
    axes.set_ylabel(f"{'xyz'[j]} [mm]")
    axes.set_title("tip paths")
    axes.grid(alpha=0.3)
    axes.legend(loc="best")


def draw_values(run: RecordedRun, axes: Axes) -> None:
    """Target, model and plant over time: of a distance, length or volume, or of a single coordinate."""
    factor, unit = (1e6, "ml") if run.kind == "volume" else (_MM, "mm")
    component = int(np.flatnonzero(run.weighted)[0])
    name = "xyz"[component] if run.goal.shape[1] >= 3 else run.kind
    draw_courses(run, lambda values: factor * values[:, component], axes)
    axes.set_ylabel(f"{name} [{unit}]")


def draw_turns(run: RecordedRun, axes: Axes) -> None:
    """How far target, model and plant have turned since rest, for a frame whose position is free."""

    def turned(values: Array) -> Array:
        _, angle = apart(np.broadcast_to(_REST, values.shape), values, run.weighted)
        return 1e3 * angle

    draw_courses(run, turned, axes)
    axes.set_ylabel("turned since rest [mrad]")


def draw_courses(run: RecordedRun, shown: Callable[[Array], Array], axes: Axes) -> None:
    """Draw target, plant and model over time.

    Args:
        run: the run.
        shown: what is drawn of goal values (m, v): (m,).
        axes: to draw into.
    """
    following = run.following
    target = Series(run.time[following], run.goal[following])
    for series, (name, color, width, alpha) in zip(
        (target, run.plant, run.model), _LINES, strict=True
    ):
        if len(series.time):
            values = shown(series.value)
            axes.plot(series.time, values, color=color, lw=width, alpha=alpha, label=name)
    axes.set_xlabel("time [s]")
    axes.grid(alpha=0.3)
    axes.legend(loc="best")


def widest_plane(points: Array, weighted: Bools | None = None) -> tuple[int, int]:
    """The two axes along which points (m, 3) spread most, in order, among those with a weight (3,)."""
    extent = np.ptp(points, axis=0) if len(points) else np.array([1.0, 0.0, 1.0])
    if weighted is not None:
        extent = np.where(weighted, extent, -1.0)
    first, second = sorted(np.argsort(extent, kind="stable")[-2:].tolist())
    return first, second


def draw_actuators(course: Series, shown: Shown, axes: Axes) -> None:
    """Draw commanded positions or efforts of actuators that share a quantity."""
    for column, name in zip(shown.columns, shown.names, strict=True):
        values = shown.quantity.scale * course.value[:, column]
        axes.plot(course.time, values, color=_colour(column), label=name)
    axes.set_ylabel(shown.quantity.label)


def draw_legend(axes: Axes) -> None:
    """Draw the names of the lines above the axes, where they cover none."""
    axes.legend(
        loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, fontsize="small",
        frameon=False, borderpad=0.1, markerscale=4,
    )  # fmt: skip


def _colour(actuator: int) -> str:
    return CABLE_COLOURS[actuator % len(CABLE_COLOURS)]


def draw_error(run: RecordedRun, axes: Axes, part: int, unit: str, factor: float) -> None:
    """Distance of model and plant from the goal, or the angle between their frames and that of the goal.

    Args:
        run: the run.
        axes: to draw into.
        part: 0 for the distance, 1 for the angle.
        unit: that is shown.
        factor: to it from SI.
    """
    for series, name, color in ((run.plant, "plant", _PLANT), (run.model, "model", _MODEL)):
        if len(series.time):
            found = factor * errors_to_goal(run, series)[part]
            axes.plot(series.time, found, color=color, label=name)
    axes.set_ylabel(f"error [{unit}]")
    axes.set_ylim(bottom=0.0)


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
    axes.axhline(_MM / run.description.rate, color=_LIMIT, ls="--", label="period")
    axes.set_ylabel("step time [ms]")
    axes.set_ylim(bottom=0.0)
    draw_legend(axes)


def draw_replay(replay: Replay, log: str, path: Path) -> None:
    """Draw recorded and replayed actuation, each above their difference."""
    courses = replay.courses
    positions, efforts = shown_quantities(replay.actuators)
    drawn = [
        *((courses.position, shown) for shown in positions),
        *((courses.effort, shown) for shown in efforts),
    ]
    figure = Figure(figsize=(12.0, max(8.0, 3.2 * len(drawn))), layout="constrained")
    axes = figure.subplots(2 * len(drawn), 1, sharex=True)
    for place, (values, shown) in enumerate(drawn):
        _draw_course(axes[2 * place], axes[2 * place + 1], courses.time, values, shown)
    for axis in axes:
        axis.grid(alpha=0.3)
    for place in range(len(positions)):
        draw_legend(axes[2 * place])
    axes[-1].set_xlabel("time [s]")
    figure.align_ylabels(axes)
    verdict = "the same" if replay.same else "different"
    figure.suptitle(
        f"{log}: {verdict}, at most {replay.fraction:.2g} of an actuator's range apart "
        f"(tolerance {replay.tolerance:g}); wide: recorded, thin: replayed"
    )
    save_figure(figure, path, dpi=130)


def _draw_course(above: Axes, below: Axes, time: Array, values: Array, shown: Shown) -> None:
    """Values (2, m, n_a) of the actuators shown, and the difference of the two."""
    values = shown.quantity.scale * values[:, :, shown.columns]
    above.set_ylabel(shown.quantity.label)
    below.set_ylabel(f"difference [{shown.quantity.shown_unit}]")
    for place, (column, name) in enumerate(zip(shown.columns, shown.names, strict=True)):
        color = _colour(column)
        above.plot(time, values[0, :, place], color=color, lw=4.0, alpha=0.3)
        above.plot(time, values[1, :, place], color=color, lw=1.2, label=name)
        below.plot(time, values[1, :, place] - values[0, :, place], color=color, lw=1.2)
    largest = float(np.abs(values[1] - values[0]).max(initial=0.0))
    if largest == 0.0:
        below.set_ylim(-1.0, 1.0)
        below.text(0.5, 0.7, "no difference", transform=below.transAxes, ha="center")


def draw_distances(found: Distances, path: Path) -> None:
    """Draw the distance of plant and model above its shares."""
    figure = Figure(figsize=(11.0, 6.5), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True)
    lines = (
        (above, "plant against model", "#222222"),
        (above, "delay", "#d55e00"),
        (above, "motion of the model in a tick", "#999999"),
        (below, "model without contact", "#222222"),
        (below, "time", "#0072b2"),
        (below, "contact basis", "#009e73"),
        (below, "state reduction", "#cc79a7"),
    )
    for axes, name, color in lines:
        series = found.series[name]
        if np.isfinite(series.value).any():
            axes.plot(series.time, _MM * series.value, color=color, lw=1.1, label=name)
    for axes in (above, below):
        axes.set_ylabel("distance [mm]")
        axes.set_ylim(bottom=0.0, top=1.2 * axes.get_ylim()[1])
        axes.grid(alpha=0.3)
        axes.legend(loc="upper right", ncols=2, fontsize="small")
    below.set_xlabel("time [s]")
    figure.suptitle(f"{found.robot}: plant and model, steps of the plant: {found.steps}")
    save_figure(figure, path, dpi=130)
