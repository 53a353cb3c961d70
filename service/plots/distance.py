"""The figure of what the distance of plant and model consists of."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from tauten.service.replay import Distances

_MM = 1e3


def draw_distances(found: Distances, path: Path) -> None:
    """Draw the distance of plant and model above its shares.

    Args:
        found: the distances.
        path: of the figure; its suffix decides the format.
    """
    figure = Figure(figsize=(11.0, 6.5), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True)
    lines = (
        (above, found.total, "plant against model", "#222222"),
        (above, found.delay, "delay", "#d55e00"),
        (above, found.tick, "motion of the model in a tick", "#999999"),
        (below, found.model, "model without contact", "#222222"),
        (below, found.time, "time", "#0072b2"),
        (below, found.contact_basis, "contact basis", "#009e73"),
        (below, found.reduction, "state reduction", "#cc79a7"),
    )
    for axes, series, name, color in lines:
        if np.isfinite(series.value).any():
            axes.plot(series.time, _MM * series.value, color=color, lw=1.1, label=name)
    for axes in (above, below):
        axes.set_ylabel("distance [mm]")
        axes.set_ylim(bottom=0.0, top=1.2 * axes.get_ylim()[1])
        axes.grid(alpha=0.3)
        axes.legend(loc="upper right", ncols=2, fontsize="small")
    below.set_xlabel("time [s]")
    figure.suptitle(f"{found.robot}: plant and model, steps of the plant: {found.steps}")
    figure.savefig(path, dpi=130)
