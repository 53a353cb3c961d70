"""Resting errors of robots at constant targets."""

from __future__ import annotations

from math import ceil
from pathlib import Path

from matplotlib.figure import Figure

from benchmarks.control import StillBench
from tauten.service.plots import save_figure

ACROSS = 4  # panels beside each other


def draw_still(result: StillBench, path: str | Path) -> None:
    """Draw how far robots rest from their targets over the distance of the targets from the start.

    Args:
        result: the runs.
        path: of the figure; its suffix decides the format.
    """
    robots = list(dict.fromkeys(run.robot for run in result.runs))
    columns = min(max(len(robots), 1), ACROSS)
    rows = max(ceil(len(robots) / columns), 1)
    figure = Figure(figsize=(3.6 * columns, 3.2 * rows), layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False)
    for unused in panels.flat[len(robots) :]:
        unused.set_axis_off()
    for robot, axes in zip(robots, panels.flat, strict=False):
        runs = [run for run in result.runs if run.robot == robot and run.best_mm is not None]
        for rests, colour, label in ((True, "C0", "at rest"), (False, "C3", "moving")):
            chosen = [run for run in runs if run.rests is rests]
            offsets = [run.offset_mm for run in chosen]
            axes.plot(offsets, [run.error_mm for run in chosen], "o", color=colour, label=label)
        axes.plot(
            [run.offset_mm for run in runs], [run.best_mm for run in runs], "k+", label="best found"
        )
        axes.set_title(robot, fontsize="medium")
        axes.set_xlabel("distance of the target [mm]")
        axes.grid(alpha=0.3)
    for first in panels[:, 0]:
        first.set_ylabel("distance at rest [mm]")
    if robots:
        panels[0, 0].legend(fontsize="small")
    save_figure(figure, path, dpi=130)
