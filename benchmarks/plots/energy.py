"""Figure of the energy of time steps."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from benchmarks.physics import EnergyBench
from tauten.service.plots import save_figure

COLOURS = {"single": "#d55e00", "converged": "#0072b2"}
NAMES = {"single": "one linearisation a step", "converged": "converged steps"}
SMALLEST = 1e-9  # of the energy at the start; below it is rounding, which is not drawn


def draw_energy(result: EnergyBench, path: str | Path) -> None:
    """Draw energy over time of each robot and motion, relative to the start.

    Args:
        result: the courses.
        path: of the figure; its suffix decides the format.
    """
    robots = list(dict.fromkeys(course.robot for course in result.courses))
    motions = list(dict.fromkeys(course.motion for course in result.courses))
    figure = Figure(figsize=(5.0 * len(motions), 3.0 * len(robots)), layout="constrained")
    panels = figure.subplots(len(robots), len(motions), squeeze=False, sharex=True)
    for course in result.courses:
        axes = panels[robots.index(course.robot), motions.index(course.motion)]
        energy = np.array(course.energy) / course.energy[0]
        axes.semilogy(
            course.time, np.where(energy > SMALLEST, energy, np.nan),
            color=COLOURS[course.steps], label=NAMES[course.steps],
        )  # fmt: skip
        axes.set_title(f"{course.robot}, {course.motion}", fontsize="medium")
    for axes in panels.ravel():
        axes.axhline(1.0, color="0.6", lw=0.8, ls="--")
        axes.grid(alpha=0.3)
        axes.set_ylabel("energy / at start")
    for axes in panels[-1]:
        axes.set_xlabel("time [s]")
    panels[0, 0].legend(fontsize="small")
    save_figure(figure, path, dpi=130)
