"""The picture of a run: paths of the tip."""

from __future__ import annotations

from itertools import pairwise
from types import SimpleNamespace

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from tauten.service.plots.run import draw_paths


def test_labels_of_a_small_movement_do_not_overlap() -> None:
    """Of a tip that moved by 0.02 mm they were one line of digits."""
    way = np.linspace(-2.5e-5, -0.5e-5, 20)[:, None] * [1.0, 0.4, 0.0]
    run = SimpleNamespace(
        following=np.full(20, True), goal=way, weighted=np.full(3, True),
        model=SimpleNamespace(value=way), plant=SimpleNamespace(value=way),
    )  # fmt: skip
    figure = Figure(figsize=(13.0, 8.0))
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((0.06, 0.06, 0.36, 0.88))
    draw_paths(run, axes)  # type: ignore[arg-type]
    canvas.draw()
    low, high = axes.get_xlim()
    shown = [
        label.get_window_extent()
        for label in axes.get_xticklabels()
        if low <= label.get_position()[0] <= high
    ]
    assert len(shown) > 2
    assert all(left.x1 < right.x0 for left, right in pairwise(shown))
