"""The figure of the manipulator's position errors over the number of modes, as the paper's Fig. 12."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from matplotlib.figure import Figure

from benchmarks.manipulator import KINDS, PostureError
from tauten.service.plots import save_figure

_LABELS = {"als": "ALS", "energy": "least energy"}


def draw_posture_errors(errors: Sequence[PostureError], path: Path) -> None:
    """Draw mean and largest error over the number of modes, one panel for each set of postures."""
    names = list(dict.fromkeys(error.postures for error in errors))
    figure = Figure(figsize=(5.2 * len(names), 4.2), layout="constrained")
    panels = figure.subplots(1, len(names), sharey=True, squeeze=False)[0]
    for axes, name in zip(panels, names, strict=True):
        for (method, _, certified), colour in zip(KINDS, ("C3", "C0", "C2"), strict=True):
            points = [
                error
                for error in errors
                if (error.postures, error.method, error.certified) == (name, method, certified)
            ]
            label = _LABELS[method] + (", certified" if certified else "")
            k = [point.k for point in points]
            axes.plot(k, [p.mean_mm for p in points], "o-", color=colour, ms=4, label=label)
            axes.plot(k, [p.max_mm for p in points], "^--", color=colour, ms=4, lw=0.8)
        axes.axhline(30.0, color="0.5", lw=0.8, ls=":")
        axes.set(title=f"{name} postures", xlabel="modes k", yscale="log")
        axes.grid(alpha=0.3, which="both", lw=0.4)
    panels[0].set_ylabel("tip error [mm]: mean (line), largest (dashes)")
    panels[0].annotate("paper, k = 23", (0.98, 30.0), xycoords=("axes fraction", "data"),
                       ha="right", va="bottom", fontsize=8, color="0.4")  # fmt: skip
    panels[-1].legend(fontsize=8)
    save_figure(figure, path, dpi=150)
