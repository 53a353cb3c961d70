"""The figure of a replay: recorded and replayed actuation."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tauten.model.numerics import Array
from tauten.service.plots.run import CABLE_COLOURS, Shown, shown_efforts, shown_positions
from tauten.service.replay import Replay


def draw_replay(replay: Replay, log: str, path: Path) -> None:
    """Draw recorded and replayed actuation, each above their difference.

    Args:
        replay: the result.
        log: name of the log, for the title.
        path: of the figure; its suffix decides the format.
    """
    courses = replay.courses
    figure = Figure(figsize=(12.0, 8.0), layout="constrained")
    axes = figure.subplots(4, 1, sharex=True)
    positions, efforts = shown_positions(replay.actuators), shown_efforts(replay.actuators)
    _draw_course(axes[0], axes[1], courses.time, courses.position, positions)
    _draw_course(axes[2], axes[3], courses.time, courses.effort, efforts)
    for axis in axes:
        axis.grid(alpha=0.3)
    axes[0].legend(loc="upper right", ncols=4, fontsize="small")
    axes[-1].set_xlabel("time [s]")
    figure.align_ylabels(axes)
    verdict = "the same" if replay.same else "different"
    figure.suptitle(
        f"{log}: {verdict}, at most {replay.fraction:.2g} of an actuator's range apart "
        f"(tolerance {replay.tolerance:g}); wide: recorded, thin: replayed"
    )
    figure.savefig(path, dpi=130)


def _draw_course(above: Axes, below: Axes, time: Array, values: Array, shown: Shown) -> None:
    """Values (2, m, n_a) of all actuators, and the difference of the two."""
    values = shown.scale * values
    above.set_ylabel(shown.label)
    below.set_ylabel(f"difference {shown.unit}".rstrip())
    for place, name in enumerate(shown.names):
        color = CABLE_COLOURS[place % len(CABLE_COLOURS)]
        above.plot(time, values[0, :, place], color=color, lw=4.0, alpha=0.3)
        above.plot(time, values[1, :, place], color=color, lw=1.2, label=name)
        below.plot(time, values[1, :, place] - values[0, :, place], color=color, lw=1.2)
    largest = float(np.abs(values[1] - values[0]).max(initial=0.0))
    if largest == 0.0:
        below.set_ylim(-1.0, 1.0)
        below.text(0.5, 0.7, "no difference", transform=below.transAxes, ha="center")
