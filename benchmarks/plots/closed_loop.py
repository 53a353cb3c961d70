"""Figures of the closed-loop benchmark: one a case, controllers by colour, the loop by line style."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from benchmarks.control import Case, CaseRuns, Outcome
from tauten.model.numerics import Array, Bools
from tauten.service.bench import Trace
from tauten.service.plots import save_figure, widest_plane

_COLORS = {"reduced": "#0072b2", "full": "#009e73", "none": "#d55e00"}
_LABELS = {"reduced": "reduced contact", "full": "full contact", "none": "no contact"}
_WIDTHS = {"reduced": 1.2, "full": 2.8, "none": 1.2}  # full lies under reduced
_MM = 1e3

Runs = tuple[tuple[Outcome, Trace], ...]


def draw_case(found: CaseRuns, h: float, path: Path) -> None:
    """Draw all runs of a case.

    Args:
        found: the case and its runs.
        h: time step [s].
        path: of the figure; its suffix decides the format.
    """
    name, case, runs = found.name, found.case, found.runs
    figure = Figure(figsize=(13.0, 7.5), layout="constrained")
    left, right = figure.subfigures(1, 2, width_ratios=(1.0, 1.25), squeeze=False)[0]
    _draw_paths(case, runs, left.subplots())
    axes = right.subplots(3, 1, sharex=True)
    time: Array = h * np.arange(len(case.targets), dtype=float)
    for outcome, trace in reversed(runs):
        _line(axes[0], outcome, time, np.maximum(_MM * trace.error, 1e-3))
        _line(axes[1], outcome, time, _MM * trace.position)
        _line(axes[2], outcome, time, trace.effort)
    _shade(time, runs[0][1].touching, axes)
    axes[0].set_yscale("log")
    for axis, label in zip(axes, ("error [mm]", "pull [mm]", "tension [N]"), strict=True):
        axis.set_ylabel(label)
        axis.grid(alpha=0.3)
        axis.set_xlim(0.0, time[-1])
    axes[-1].set_xlabel("time [s], grey: the robot touches itself")
    right.align_ylabels(axes)
    names = ", ".join(_summary(runs))
    figure.suptitle(f"{name}: RMS error, open / closed loop: {names}")
    save_figure(figure, path, dpi=130)


def _draw_paths(case: Case, runs: Runs, axes: Axes) -> None:
    target = case.targets[:, :3] if case.targets.shape[1] >= 3 else np.zeros((0, 3))
    i, j = widest_plane(target if len(target) else runs[0][1].effector)
    line = ("o", 8.0) if case.from_tick else ("-", 0.0)  # a step has no points in between
    axes.plot(
        _MM * target[:, i], _MM * target[:, j], line[0], ms=line[1],
        color="#222222", lw=5.0, alpha=0.25,
    )  # fmt: skip
    for outcome, trace in reversed(runs):
        _line(axes, outcome, _MM * trace.effector[:, i], _MM * trace.effector[:, j])
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel(f"{'xyz'[i]} [mm]")
    axes.set_ylabel(f"{'xyz'[j]} [mm]")
    axes.set_title("path of the robot's effector")
    axes.grid(alpha=0.3)
    known = [Line2D([], [], color="#222222", lw=5.0, alpha=0.25, label="target")]
    for contact in dict.fromkeys(outcome.contact for outcome, _ in runs):
        known.append(Line2D([], [], color=_COLORS[contact], label=_LABELS[contact]))
    known.append(Line2D([], [], color="#777777", ls="--", label="open loop"))
    known.append(Line2D([], [], color="#777777", ls="-", label="closed loop"))
    axes.legend(handles=known, loc="best")


def _line(axes: Axes, outcome: Outcome, x: Array, y: Array) -> None:
    axes.plot(
        x,
        y,
        color=_COLORS[outcome.contact],
        lw=_WIDTHS[outcome.contact],
        ls="-" if outcome.closed else "--",
        alpha=0.55 if outcome.contact == "full" else 0.95,
    )


def _shade(time: Array, touching: Bools, axes: list[Axes]) -> None:
    for axis in axes:
        axis.fill_between(
            time, 0.0, 1.0, where=touching.tolist(), color="#000000", alpha=0.07,
            transform=axis.get_xaxis_transform(), lw=0.0,
        )  # fmt: skip


def _summary(runs: Runs) -> list[str]:
    """RMS errors by contact, open and closed loop."""
    found: dict[str, dict[bool, float]] = {}
    for outcome, _ in runs:
        found.setdefault(outcome.contact, {})[outcome.closed] = outcome.rms_mm
    text = []
    for contact, values in found.items():
        both = [f"{values[closed]:.2f}" if closed in values else "-" for closed in (False, True)]
        text.append(f"{_LABELS[contact]} {both[0]} / {both[1]} mm")
    return text
