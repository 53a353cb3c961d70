"""A replay on paper: verdict as JSON, every tick as CSV, a figure."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tauten.model.numerics import Array
from tauten.service.process import write_text
from tauten.service.replay.replaying import Replay

VERDICT, TICKS, FIGURE = "replay.json", "replay.csv", "replay.png"

_COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")


def write_report(replay: Replay, log: str, folder: Path) -> None:
    """Write all three into a folder.

    Args:
        replay: what came out.
        log: name of the log, for the verdict.
        folder: made where it is not there.

    Raises:
        OSError: the folder cannot be written to.
    """
    verdict = {
        "log": log,
        "same": replay.same,
        "ticks": replay.ticks,
        "tolerance": replay.tolerance,
        "fraction": replay.fraction,
        "worst_tick": replay.worst_tick,
        "statuses": replay.statuses,
        "speed": replay.speed,
        "cables": {
            name: {"pull_m": float(pull), "tension_n": float(tension)}
            for name, pull, tension in zip(replay.cables, replay.pull, replay.tension, strict=True)
        },
        "notes": list(replay.notes),
    }
    write_text(folder / VERDICT, json.dumps(verdict, indent=2) + "\n")
    write_text(folder / TICKS, tick_table(replay))
    draw_replay(replay, log, folder / FIGURE)


def tick_table(replay: Replay) -> str:
    """Every tick as a line of CSV: recorded and replayed pull [m], tension [N] and status."""
    courses, text = replay.courses, io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    columns = [
        f"{kind} {name} {when}"
        for name in replay.cables
        for kind in ("pull", "tension")
        for when in ("recorded", "replayed")
    ]
    writer.writerow(["tick", "time", *columns, "status recorded", "status replayed"])
    for tick, (time, status) in enumerate(zip(courses.time, courses.status, strict=True)):
        values = []
        for cable in range(len(replay.cables)):
            values += courses.pull[:, tick, cable].tolist()
            values += courses.tension[:, tick, cable].tolist()
        writer.writerow([tick, f"{time:.6f}", *(f"{value:.9g}" for value in values), *status])
    return text.getvalue()


def draw_replay(replay: Replay, log: str, path: Path) -> None:
    """Recorded and replayed actuation above their difference."""
    courses = replay.courses
    figure = Figure(figsize=(12.0, 8.0), layout="constrained")
    axes = figure.subplots(4, 1, sharex=True)
    _draw_course(axes[0], axes[1], courses.time, 1e3 * courses.pull, replay.cables)
    _draw_course(axes[2], axes[3], courses.time, courses.tension, replay.cables)
    labels = ("pull [mm]", "difference [mm]", "tension [N]", "difference [N]")
    for axis, label in zip(axes, labels, strict=True):
        axis.set_ylabel(label)
        axis.grid(alpha=0.3)
    axes[0].legend(loc="upper right", ncols=4, fontsize="small")
    axes[-1].set_xlabel("time [s]")
    figure.align_ylabels(axes)
    verdict = "the same" if replay.same else "different"
    figure.suptitle(
        f"{log}: {verdict}, at most {replay.fraction:.2g} of a cable's range apart "
        f"(tolerance {replay.tolerance:g}); wide: recorded, thin: replayed"
    )
    figure.savefig(path, dpi=130)


def _draw_course(
    above: Axes, below: Axes, time: Array, values: Array, cables: tuple[str, ...]
) -> None:
    """Values (2, m, n_a), and what lies between the two."""
    for cable, name in enumerate(cables):
        color = _COLORS[cable % len(_COLORS)]
        above.plot(time, values[0, :, cable], color=color, lw=4.0, alpha=0.3)
        above.plot(time, values[1, :, cable], color=color, lw=1.2, label=name)
        below.plot(time, values[1, :, cable] - values[0, :, cable], color=color, lw=1.2)
    largest = float(np.abs(values[1] - values[0]).max(initial=0.0))
    if largest == 0.0:
        below.set_ylim(-1.0, 1.0)
        below.text(0.5, 0.7, "none at all", transform=below.transAxes, ha="center")
